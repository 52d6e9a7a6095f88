#include "host/io/mesh/ply_face_labels.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "host/input/safe_text.hpp"
#include "host/io/mesh/mesh_formats.hpp"

namespace weft::io {
namespace {

constexpr long long most_labels = 1'000'000;

const std::string& name_of(const std::map<long long, std::string>& names, long long number) {
  static const std::string none;
  const auto found = names.find(number);
  return found == names.end() ? none : found->second;
}

/// Adds the label of one more triangle.
void add_label(const std::string& name, std::map<std::string, Index>& numbers,
               std::vector<std::string>& names, std::vector<Index>& labels) {
  const auto [entry, fresh] = numbers.try_emplace(name, static_cast<Index>(names.size()));
  if (fresh) names.push_back(name);
  labels.push_back(entry->second);
}

}  // namespace

void PlyFaceLabels::read_comment(const std::vector<std::string_view>& words,
                                 std::string_view line) {
  if (words.size() < 4) return;
  auto* names = words[1] == "object"  ? &objects_
                : words[1] == "panel" ? &panels_
                : words[1] == "label" ? &labels_
                                      : nullptr;
  long long number = -1;
  if (names == nullptr || !parse_number(words[2], number) || number < 0 || number >= most_labels)
    return;
  // Names may have spaces.
  const auto begin = static_cast<std::size_t>(words[3].data() - line.data());
  const auto end =
      static_cast<std::size_t>(words.back().data() + words.back().size() - line.data());
  names->insert_or_assign(number, one_line(line.substr(begin, end - begin)));
}

void PlyFaceLabels::take(const std::string& property, double value, Face& face) {
  const bool whole = value >= -1 && value < most_labels && value == std::floor(value);
  const long long number = whole ? static_cast<long long>(value) : -1;
  if (property == "object") face.object = number;
  if (property == "panel") face.panel = number;
}

void PlyFaceLabels::add_triangle(const Face& face) {
  if (!objects_.empty() || !panels_.empty()) faces_.push_back(face);
}

void PlyFaceLabels::hand_over(Mesh& mesh) {
  if (faces_.size() != mesh.triangles.size()) return;
  std::map<std::string, Index> group_numbers, object_numbers;
  for (const Face& face : faces_) {
    const std::string& object = name_of(objects_, face.object);
    const std::string& panel = name_of(panels_, face.panel);
    add_label(panel.empty() ? object : panel, group_numbers, mesh.group_names, mesh.group);
    if (!panels_.empty() && !objects_.empty())
      add_label(object, object_numbers, mesh.object_names, mesh.object);
  }
  std::map<std::string, std::string> labels;
  for (const auto& [number, label] : labels_)
    if (const std::string& panel = name_of(panels_, number); !panel.empty())
      labels.insert_or_assign(panel, label);
  take_panel_labels(labels, mesh);
}

PlyPanels::PlyPanels(const std::vector<NamedMesh>& meshes)
    : meshes_(meshes), with_objects_(meshes.size() > 1) {
  std::int32_t count = 0;
  for (const NamedMesh& named : meshes) {
    with_panels_ = with_panels_ || has_panels(named.mesh);
    first_.push_back(count);
    count += static_cast<std::int32_t>(named.mesh.part_names.size());
  }
}

std::string PlyPanels::comments() const {
  std::string text;
  for (std::size_t m = 0; m < meshes_.size(); ++m)
    if (!meshes_[m].name.empty())
      text += "comment object " + std::to_string(m) + " " + one_line(meshes_[m].name) + "\n";
  if (!with_panels_) return text;
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    const Mesh& mesh = meshes_[m].mesh;
    if (!has_panels(mesh)) continue;
    for (std::size_t p = 0; p < mesh.part_names.size(); ++p) {
      const std::string number = std::to_string(first_[m] + static_cast<std::int32_t>(p)) + " ";
      text += "comment panel " + number + one_line(mesh.part_names[p]) + "\n";
      if (p < mesh.part_labels.size() && !mesh.part_labels[p].empty())
        text += "comment label " + number + one_line(mesh.part_labels[p]) + "\n";
    }
  }
  return text;
}

std::string PlyPanels::properties() const {
  return std::string(with_objects_ ? "property int object\n" : "") +
         (with_panels_ ? "property int panel\n" : "");
}

void PlyPanels::append_row(std::string& bytes, std::size_t mesh, std::size_t triangle) const {
  const auto append = [&](std::int32_t value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  if (with_objects_) append(static_cast<std::int32_t>(mesh));
  if (!with_panels_) return;
  const std::vector<Index>& part = meshes_[mesh].mesh.part;
  append(!has_panels(meshes_[mesh].mesh) ? -1 : first_[mesh] + part[triangle]);
}

}  // namespace weft::io
