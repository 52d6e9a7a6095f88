#include "host/io/pattern/garment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "host/input/quantity.hpp"
#include "host/io/pattern/edge_cuts.hpp"
#include "host/io/pattern/edge_sampling.hpp"
#include "host/io/pattern/panel_chords.hpp"
#include "host/io/pattern/stitch_direction.hpp"
#include "host/meshing/planar_mesher.hpp"
#include "weft/core/at.hpp"
#include "weft/error.hpp"

namespace weft::io {
namespace {

/// Parts of an edge that is only looked at.
constexpr Index fine_parts = 64;

/// The outline of a panel as its mesh has it: seen from the front, counter-clockwise.
class PanelOutline {
 public:
  /// @param cuts   [edges] see EdgeCuts
  /// @param turned see StitchDirections
  PanelOutline(const std::vector<EdgeCurve>& curves, const std::vector<std::vector<double>>& cuts,
               bool turned) {
    for (std::size_t e = 0; e < curves.size(); ++e) {
      first_.push_back(static_cast<Index>(points_.size()));
      const std::vector<Vec2<double>> along = curves[e].sample(cuts[e]);
      points_.insert(points_.end(), along.begin(), along.end() - 1);
    }
    first_.push_back(static_cast<Index>(points_.size()));
    // The front is where the outline runs counter-clockwise, unless the panel is turned.
    mirrored_ = (signed_area(points_) < 0) != turned;
    if (mirrored_)
      for (Vec2<double>& p : points_) p[0] = -p[0];
    reversed_ = signed_area(points_) < 0;
    if (reversed_) std::reverse(points_.begin(), points_.end());
  }

  const std::vector<Vec2<double>>& points() const { return points_; }
  bool mirrored() const { return mirrored_; }
  /// Numbers of the points along an edge, with both ends, as the edge runs.
  std::vector<Index> along(std::size_t edge) const {
    const auto n = static_cast<Index>(points_.size());
    std::vector<Index> numbers;
    for (Index k = first_[edge]; k <= first_[edge + 1]; ++k)
      numbers.push_back(reversed_ ? n - 1 - k % n : k % n);
    return numbers;
  }
  /// The edge that a side of the outline is part of.
  std::size_t edge_of(std::size_t side) const {
    const auto n = static_cast<Index>(points_.size());
    const auto k = static_cast<Index>(side);
    const Index place = reversed_ ? (2 * n - 2 - k) % n : k;
    const auto after = std::upper_bound(first_.begin(), first_.end(), place);
    return static_cast<std::size_t>(after - first_.begin()) - 1;
  }

 private:
  std::vector<Vec2<double>> points_;
  std::vector<Index> first_;  ///< [edges + 1] of each edge, in the direction of the file
  bool mirrored_ = false;
  bool reversed_ = false;
};

/// A name as one word that groups of mesh files and keys of scenes can have.
std::string word_of(std::string name) {
  for (char& c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!plain && c != '-') c = '_';
  }
  return name;
}

class GarmentMaker {
 public:
  GarmentMaker(const SewingPattern& pattern, double edge, const EdgeField& given)
      : pattern_(pattern), edge_(edge), curves_(edge_curves(pattern)) {
    check_outlines(given);
    directions_ = choose_directions(pattern);
    garment_.notes = pattern.notes;
    garment_.notes.insert(garment_.notes.end(), directions_.notes.begin(), directions_.notes.end());
    cuts_ = cut_edges(pattern, curves_, directions_.opposite,
                      edge_parts(pattern, curves_, directions_.opposite, edge));
    garment_.notes.insert(garment_.notes.end(), cuts_.notes.begin(), cuts_.notes.end());
  }

  Garment run() {
    std::vector<PlanarMesh> meshes;
    for (std::size_t p = 0; p < pattern_.panels.size(); ++p) {
      outlines_.emplace_back(curves_[p], cuts_.distances[p], directions_.turned[p]);
      check_sampled(p);
      meshes.push_back(mesh_outline(outlines_[p].points(), edge_));
      first_.push_back(first_.back() + static_cast<Index>(meshes[p].points.size()));
    }
    sew();
    // Points that split triangles come after all others of a panel, which moves the panels after
    // it.
    std::vector<Index> outline_sizes;
    for (const PanelOutline& outline : outlines_)
      outline_sizes.push_back(static_cast<Index>(outline.points().size()));
    split_chords(meshes, outline_sizes, first_, seam_pairs());
    renumber(meshes);
    for (std::size_t p = 0; p < meshes.size(); ++p) add_panel(p, meshes[p]);
    add_parts();
    add_labels();
    return std::move(garment_);
  }

 private:
  std::string panel_field(std::size_t p) const {
    return "pattern.panels." + pattern_.panels[p].name;
  }

  /// @throws SceneError for what no edge length could mesh
  void check_outlines(const EdgeField& given) const {
    double area = 0, largest = 0;
    for (std::size_t p = 0; p < curves_.size(); ++p) {
      std::vector<std::vector<double>> cuts;
      for (std::size_t e = 0; e < curves_[p].size(); ++e) {
        const bool line = pattern_.panels[p].edges[e].shape == PatternEdge::Shape::line;
        cuts.push_back(curves_[p][e].even_distances(line ? 1 : fine_parts));
      }
      const PanelOutline outline(curves_[p], cuts, false);
      if (const auto crossing = outline.points().size() < 3 ? std::optional<OutlineCrossing>({0, 0})
                                                            : find_crossing(outline.points()))
        refuse_crossing(p, outline, *crossing, "");
      const double own = signed_area(outline.points());
      if (!(own > 0))
        throw SceneError(pattern_.file, panel_field(p), "no area", "an outline with an area");
      area += own;
      largest = std::max(largest, own);
    }
    if (!(edge_ <= std::sqrt(largest)))
      throw SceneError(given.file, given.field, short_number(edge_) + " m",
                       "a length in metres that is no longer than panels are; those of " +
                           pattern_.file + " have up to " + short_number(largest) +
                           " square metres, see units_in_meter");
    const double triangles = area * 4 / (edge_ * edge_ * std::numbers::sqrt3);
    if (!(triangles <= most_garment_triangles))
      throw SceneError(given.file, given.field,
                       short_number(edge_) + " m, which makes about " +
                           short_number(std::round(triangles)) + " triangles of " + pattern_.file,
                       "an edge length that makes up to " + short_number(most_garment_triangles));
  }

  [[noreturn]] void refuse_crossing(std::size_t p, const PanelOutline& outline,
                                    const OutlineCrossing& crossing, const std::string& why) const {
    const std::size_t a = outline.edge_of(crossing[0]), b = outline.edge_of(crossing[1]);
    const auto [low, high] = std::minmax(a, b);
    throw SceneError(pattern_.file, panel_field(p),
                     low == high ? "edge " + std::to_string(low) + " crosses itself" + why
                                 : "edges " + std::to_string(low) + " and " + std::to_string(high) +
                                       " cross or touch" + why,
                     "an outline that does not cross or touch itself");
  }

  void check_sampled(std::size_t p) const {
    const std::vector<Vec2<double>>& points = outlines_[p].points();
    if (points.size() < 3)
      throw SceneError(pattern_.file, panel_field(p),
                       "too small for edges of " + short_number(edge_) + " m",
                       "a shorter edge length, or a larger panel");
    if (const auto crossing = find_crossing(points))
      refuse_crossing(p, outlines_[p], *crossing, " at edges of " + short_number(edge_) + " m");
  }

  /// Vertices of one side of a stitch, in the numbers of all panels.
  std::vector<Index> side_vertices(const PatternSide& side) const {
    std::vector<Index> vertices = outlines_[at(side.panel)].along(at(side.edge));
    for (Index& v : vertices) v += first_[at(side.panel)];
    return vertices;
  }

  void sew() {
    std::set<std::array<Index, 2>> known;
    for (std::size_t k = 0; k < pattern_.stitches.size(); ++k) {
      const std::vector<Index> a = side_vertices(pattern_.stitches[k].sides[0]);
      std::vector<Index> b = side_vertices(pattern_.stitches[k].sides[1]);
      if (directions_.opposite[k]) std::reverse(b.begin(), b.end());
      GarmentSeam seam{static_cast<Index>(k), {}};
      for (std::size_t i = 0; i < a.size(); ++i) {
        const auto [low, high] = std::minmax(a[i], b[i]);
        if (low != high && known.insert({low, high}).second) seam.pairs.push_back({a[i], b[i]});
      }
      garment_.seams.push_back(std::move(seam));
    }
  }

  std::vector<std::array<Index, 2>> seam_pairs() const {
    std::vector<std::array<Index, 2>> pairs;
    for (const GarmentSeam& seam : garment_.seams)
      pairs.insert(pairs.end(), seam.pairs.begin(), seam.pairs.end());
    return pairs;
  }

  /// Moves the numbers of sewn vertices behind the points that panels have got since.
  void renumber(const std::vector<PlanarMesh>& meshes) {
    std::vector<Index> moved{0};
    for (const PlanarMesh& mesh : meshes)
      moved.push_back(moved.back() + static_cast<Index>(mesh.points.size()));
    for (GarmentSeam& seam : garment_.seams)
      for (auto& pair : seam.pairs)
        for (Index& v : pair) {
          const auto after = std::upper_bound(first_.begin(), first_.end(), v);
          const auto p = static_cast<std::size_t>(after - first_.begin()) - 1;
          v += moved[p] - first_[p];
        }
    first_ = moved;
  }

  void add_panel(std::size_t p, const PlanarMesh& planar) {
    const PatternPanel& panel = pattern_.panels[p];
    Mesh& mesh = garment_.mesh;
    std::string name = word_of(panel.name);
    while (!names_.insert(name).second) name += "_2";
    GarmentPanel part{name,
                      word_of(panel.label),
                      first_[p],
                      static_cast<Index>(planar.points.size()),
                      static_cast<Index>(mesh.triangles.size()),
                      static_cast<Index>(planar.triangles.size()),
                      {}};
    for (std::size_t e = 0; e < panel.edges.size(); ++e)
      part.edges.push_back(side_vertices({static_cast<Index>(p), static_cast<Index>(e)}));
    const Vec3<double> origin = placed(panel, {0, 0});
    const double grain = std::max(length(panel.grain), 1e-300);
    const Vec2<double> warp{(outlines_[p].mirrored() ? -1 : 1) * panel.grain[0] / grain,
                            panel.grain[1] / grain};
    const bool warp_along_x = std::abs((placed(panel, {1, 0}) - origin)[1]) >
                              1.001 * std::abs((placed(panel, {0, 1}) - origin)[1]);
    for (const Vec2<double>& q : planar.points) {
      mesh.positions.push_back(placed(panel, {outlines_[p].mirrored() ? -q[0] : q[0], q[1]}));
      if (panel.grain != Vec2<double>{0, 0})
        mesh.material.push_back({dot(warp, q), warp[0] * q[1] - warp[1] * q[0]});
      else
        mesh.material.push_back(warp_along_x ? q : Vec2<double>{q[1], -q[0]});
    }
    for (const Tri& t : planar.triangles) {
      mesh.triangles.push_back({{t.v[0] + first_[p], t.v[1] + first_[p], t.v[2] + first_[p]}});
      mesh.group.push_back(static_cast<Index>(p));
    }
    mesh.group_names.push_back(name);
    garment_.panels.push_back(std::move(part));
  }

  void add_parts() {
    const auto labelled = [](const GarmentPanel& panel) { return !panel.label.empty(); };
    if (std::none_of(garment_.panels.begin(), garment_.panels.end(), labelled)) return;
    Mesh& mesh = garment_.mesh;
    for (const GarmentPanel& panel : garment_.panels) {
      const std::string& name = panel.label.empty() ? panel.name : panel.label;
      const auto found = std::find(mesh.part_names.begin(), mesh.part_names.end(), name);
      const auto number = static_cast<Index>(found - mesh.part_names.begin());
      if (found == mesh.part_names.end()) mesh.part_names.push_back(name);
      mesh.part.insert(mesh.part.end(), at(panel.triangle_count), number);
    }
  }

  void add_labels() {
    std::map<std::string, std::set<Index>> labels;
    for (std::size_t p = 0; p < pattern_.panels.size(); ++p)
      for (std::size_t e = 0; e < pattern_.panels[p].edges.size(); ++e) {
        const std::string& label = pattern_.panels[p].edges[e].label;
        if (label.empty()) continue;
        const std::vector<Index> vertices =
            side_vertices({static_cast<Index>(p), static_cast<Index>(e)});
        labels[label].insert(vertices.begin(), vertices.end());
      }
    for (const auto& [label, vertices] : labels)
      garment_.labels.push_back({label, {vertices.begin(), vertices.end()}});
  }

  const SewingPattern& pattern_;
  double edge_;
  std::vector<std::vector<EdgeCurve>> curves_;
  StitchDirections directions_;
  EdgeCuts cuts_;
  std::vector<PanelOutline> outlines_;
  std::vector<Index> first_{0};  ///< [panels + 1] first vertex
  std::set<std::string> names_;
  Garment garment_;
};

}  // namespace

Garment make_garment(const SewingPattern& pattern, double edge, const EdgeField& given) {
  if (!quantity::length.holds(edge))
    throw SceneError(given.file, given.field, short_number(edge), quantity::length.allowed());
  return GarmentMaker(pattern, edge, given).run();
}

}  // namespace weft::io
