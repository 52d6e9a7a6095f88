#include "tests/unit/lab/worn/sculpted.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/unit/lab/worn/tailored.hpp"
#include "weft/core/at.hpp"

namespace weft::lab::test {
namespace {

constexpr double degree = std::numbers::pi / 180;
// The limits that users are promised: how far openings may slide, as shares of the body's height,
// and by what angle they may turn.
constexpr double trunk_limit = 0.06, limb_limit = 0.1, turn_limit = 60 * degree;
// The share of a panel that may be stretched by more than this factor.
constexpr double stretch_limit = 1.25, stretched_limit = 0.02;

// The random choices of a fit, made before its garment is cut.
struct Setting {
  Cut cut{};
  Proportions proportions;
  Pose start, end;
  Tailoring how;
  bool moved = false;  // to the pose `end`
};

// A garment between its start and its end. All moves happen on the body in the pose of the start;
// `settle` then takes garment and body to the pose of the end.
class Wearing {
 public:
  Wearing(const Setting& setting, Draw& draw)
      : body(setting.proportions, setting.start),
        to(setting.proportions, setting.moved ? setting.end : setting.start),
        garment(tailored(setting.cut, body, setting.how, draw)),
        h(body.height()),
        t(body.trunk_length()),
        moved(setting.moved),
        edges(edges_of(garment.triangles).edges),
        x(garment.positions),
        parts(garment.parts) {
    for (const Point& p : x) level.push_back(body.distance(p, parts));
  }

  const Sculpture body, to;
  const Tailored garment;
  const double h, t;
  const bool moved;
  const std::vector<Edge> edges;
  std::vector<Point> x;       // on the body in its first pose
  std::vector<double> level;  // distance from the body at the start
  unsigned parts;             // of the body that cloth stays outside of

  const Point& first(std::size_t v) const { return garment.positions[v]; }
  double hip_z() const { return body.hip_z(); }

  // Which vertices belong to panels whose label begins with this.
  std::vector<char> of(const std::string& label) const {
    std::vector<char> chosen(x.size(), 0);
    for (std::size_t k = 0; k < garment.triangles.size(); ++k)
      if (garment.labels[at(garment.group[k])].rfind(label, 0) == 0)
        for (const Index v : garment.triangles[k].v) chosen[at(v)] = 1;
    return chosen;
  }

  // Those of them that are around this limb.
  std::vector<char> of(const std::string& label, Part limb) const {
    std::vector<char> chosen = of(label);
    for (std::size_t v = 0; v < x.size(); ++v)
      if (chosen[v] &&
          body.nearest_part(first(v), limb | (limb & legs ? trunk | legs : trunk)) != limb &&
          body.along(limb, first(v)) < 0.1 * h)
        chosen[v] = 0;
      else if (chosen[v] && (limb & legs) && body.nearest_part(first(v), legs) != limb)
        chosen[v] = 0;
    return chosen;
  }

  // Keeps vertices at the distance from the body that they had; those far from it only outside.
  void keep_level(std::size_t v, unsigned from) {
    for (int round = 0; round < 2; ++round) {
      Point g{0, 0, 1};
      const double d = body.distance(x[v], from, &g);
      const double wanted = level[v] < 0.06 ? level[v] : std::max(d, 0.01);
      if (std::abs(wanted - d) < 1e-4) return;
      const double size = length(g);
      if (size > 0.1) x[v] += (std::clamp(wanted - d, -0.05, 0.05) / size) * g;
    }
  }

  // Moves every vertex along a velocity field, at a constant distance from the body.
  void flow(const std::function<Point(std::size_t, Point)>& velocity, int steps) {
    for (int step = 0; step < steps; ++step)
      for (std::size_t v = 0; v < x.size(); ++v) {
        x[v] += (1.0 / steps) * velocity(v, x[v]);
        keep_level(v, parts);
      }
  }

  // Puts every vertex where `place` says, blended with where it is by its weight.
  void put(const std::function<Point(std::size_t)>& place,
           const std::function<double(std::size_t)>& weight) {
    for (std::size_t v = 0; v < x.size(); ++v) {
      const double w = weight(v);
      if (w > 0) x[v] += w * (place(v) - x[v]);
    }
  }

  // Evens out displacements, so that cloth between what moved and what did not is not torn.
  void smooth(int rounds, double share) {
    std::vector<double> degree_of(x.size());
    for (const Edge& e : edges)
      for (const Index v : e.v) degree_of[at(v)] += 1;
    for (int round = 0; round < rounds; ++round) {
      std::vector<Point> sum(x.size(), Point{0, 0, 0});
      for (const Edge& e : edges)
        for (int c = 0; c < 2; ++c) sum[at(e.v[c])] += x[at(e.v[1 - c])] - first(at(e.v[1 - c]));
      for (std::size_t v = 0; v < x.size(); ++v)
        x[v] += share * ((1 / degree_of[v]) * sum[v] - (x[v] - first(v)));
    }
  }

  void wrinkle(double size, Draw& draw) {
    std::vector<Point> normal(x.size(), Point{0, 0, 0});
    for (const Tri& tri : garment.triangles) {
      const Point n = cross(x[at(tri.v[1])] - x[at(tri.v[0])], x[at(tri.v[2])] - x[at(tri.v[0])]);
      for (const Index v : tri.v) normal[at(v)] += n;
    }
    for (int wave = 0; wave < 3; ++wave) {
      const double k = 2 * std::numbers::pi / draw.between(0.09, 0.2);
      const Point direction =
          k * unit({draw.between(-1, 1), draw.between(-1, 1), draw.between(-1, 1)});
      const double phase = draw.between(0, 6), amplitude = size * draw.between(0.3, 0.6);
      for (std::size_t v = 0; v < x.size(); ++v)
        if (length(normal[v]) > 0)
          x[v] +=
              (amplitude * (std::sin(dot(direction, first(v)) + phase) + 0.3)) * unit(normal[v]);
    }
  }

  // Takes the garment along as the body moves.
  void carry() {
    if (!moved) return;
    std::vector<Sculpture::Weights> w;
    for (const Point& p : x) w.push_back(body.weights(p));
    for (int round = 0; round < 8; ++round) {
      std::vector<Sculpture::Weights> sum = w;
      std::vector<double> count(x.size(), 1);
      for (const Edge& e : edges)
        for (int c = 0; c < 2; ++c) {
          for (std::size_t b = 0; b < bone_count; ++b) sum[at(e.v[c])][b] += w[at(e.v[1 - c])][b];
          count[at(e.v[c])] += 1;
        }
      for (std::size_t v = 0; v < x.size(); ++v)
        for (std::size_t b = 0; b < bone_count; ++b) w[v][b] = sum[v][b] / count[v];
    }
    for (std::size_t v = 0; v < x.size(); ++v) x[v] = body.carried(x[v], w[v], to);
  }

  // The largest share of a panel's area that is stretched by more than the limit.
  double stretched_share() const {
    std::vector<double> area(garment.names.size(), 0), stretched(garment.names.size(), 0);
    for (std::size_t k = 0; k < garment.triangles.size(); ++k) {
      const auto& v = garment.triangles[k].v;
      const Point e1 = first(at(v[1])) - first(at(v[0])), e2 = first(at(v[2])) - first(at(v[0]));
      const double l = length(e1), twice = length(cross(e1, e2));
      if (!(twice > 1e-12)) continue;
      area[at(garment.group[k])] += twice;
      // The deformation gradient in the triangle's plane, columns f1 and f2.
      const Point f1 = (1 / l) * (x[at(v[1])] - x[at(v[0])]);
      const Point f2 = (l / twice) * (x[at(v[2])] - x[at(v[0])] - (dot(e1, e2) / l) * f1);
      const double a = dot(f1, f1), b = dot(f1, f2), c = dot(f2, f2);
      const double largest = 0.5 * (a + c) + std::sqrt(0.25 * (a - c) * (a - c) + b * b);
      if (largest > stretch_limit * stretch_limit) stretched[at(garment.group[k])] += twice;
    }
    double worst = 0;
    for (std::size_t g = 0; g < area.size(); ++g) worst = std::max(worst, stretched[g] / area[g]);
    return worst;
  }

  // Relaxes until no panel is stretched, unless stretching is the planted fault.
  void relax_until_slack(int batches) {
    for (int batch = 0; batch < batches; ++batch) {
      relax(30);
      if (stretched_share() < 0.6 * stretched_limit) return;
    }
  }

  // Lets cloth that is stretched or shortened slip over the body in its last pose: lengths of edges
  // as in position based dynamics (Mueller et al. 2007).
  void relax(int rounds) {
    std::vector<double> rest;
    for (const Edge& e : edges) rest.push_back(length(first(at(e.v[0])) - first(at(e.v[1]))));
    // How far a vertex may still move before it can be too close to the body.
    std::vector<double> clear(x.size(), 0);
    for (int round = 0; round < rounds; ++round) {
      const std::vector<Point> before = x;
      for (std::size_t i = 0; i < edges.size(); ++i) {
        Point& a = x[at(edges[i].v[0])];
        Point& b = x[at(edges[i].v[1])];
        const Point ab = b - a;
        const double l = std::sqrt(dot(ab, ab));
        if (l < 1e-9) continue;
        const double excess = l - rest[i];
        const Point move = ((excess > 0 ? 0.45 : 0.1) * excess / l) * ab;
        a += move;
        b -= move;
      }
      for (std::size_t v = 0; v < x.size(); ++v) {
        const double wanted = std::min(level[v], 0.006);
        clear[v] -= 1.2 * length(x[v] - before[v]);
        if (clear[v] > 0) continue;
        const double d = to.distance(x[v], parts);
        clear[v] = std::max(0.0, d - wanted);
        if (d >= wanted) continue;
        const Point g = to.gradient(x[v], parts);
        const double size = length(g);
        if (size > 0.1) x[v] += (std::min(wanted - d, 0.03) / size) * g;
      }
    }
  }
};

// ------------------------------------------------------------------------------ moves of garments

// Direction in which cloth slides down over the surface of the body.
Point downhill(const Wearing& w, Point p) {
  const Point g = w.body.gradient(p, w.parts);
  const double size = length(g);
  if (size < 0.1) return {0, 0, -1};
  const Point n = (1 / size) * g;
  const Point down{0, 0, -1};
  const Point along = down - dot(down, n) * n;
  return length(along) > 0.2 ? unit(along) : Point{0, 0, 0};
}

// The garment slides down: by `amount` at its upper edge, not at all at `still_z` and below.
void slide_down(Wearing& w, double amount, double still_z) {
  double top = -1;
  for (const Point& p : w.x) top = std::max(top, p[2]);
  w.flow(
      [&](std::size_t v, Point) {
        const double share = (w.first(v)[2] - still_z) / (top - still_z);
        return Point{0, 0, -amount * std::clamp(share, 0.0, 1.0)};
      },
      8);
}

// Turns the garment about the body's vertical axis.
void turn(Wearing& w, double angle) {
  w.flow(
      [&](std::size_t, Point p) {
        const Point axis = w.body.bone(Bone::pelvis).o;
        return angle * Point{-(p[1] - axis[1]), p[0] - axis[0], 0};
      },
      12);
}

// How far along its limb a sleeve or leg reaches. [m]
double end_of(const Wearing& w, Part limb, const std::vector<char>& tube) {
  double end = 0;
  for (std::size_t v = 0; v < w.x.size(); ++v)
    if (tube[v]) end = std::max(end, w.body.along(limb, w.first(v)));
  return end;
}

// A sleeve or leg slides along its limb, farthest at its end.
void slide_tube(Wearing& w, Part limb, const std::string& label, double amount) {
  const std::vector<char> tube = w.of(label, limb);
  const double end = end_of(w, limb, tube);
  w.flow(
      [&](std::size_t v, Point p) {
        if (!tube[v]) return Point{0, 0, 0};
        const double s = std::clamp(w.body.along(limb, w.first(v)) / end, 0.0, 1.0);
        return (amount * s) * w.body.axis_direction(limb, p);
      },
      10);
}

void twist_tube(Wearing& w, Part limb, const std::string& label, double angle) {
  const std::vector<char> tube = w.of(label, limb);
  const double end = end_of(w, limb, tube);
  w.flow(
      [&](std::size_t v, Point p) {
        if (!tube[v]) return Point{0, 0, 0};
        const double s = smooth_step(0.1, 0.85, w.body.along(limb, w.first(v)) / end);
        return (angle * s) * cross(w.body.axis_direction(limb, p), p - w.body.axis_point(limb, p));
      },
      10);
}

// A spot of a panel is pulled out like a tent.
void pull(Wearing& w, const std::string& label, double radius, double slope) {
  const std::vector<char> panel = w.of(label);
  Point middle{0, 0, 0};
  double count = 0;
  for (std::size_t v = 0; v < w.x.size(); ++v)
    if (panel[v]) {
      middle += w.first(v);
      count += 1;
    }
  middle = (1 / count) * middle;
  std::size_t nearest = 0;
  for (std::size_t v = 0; v < w.x.size(); ++v)
    if (panel[v] && length(w.first(v) - middle) < length(w.first(nearest) - middle)) nearest = v;
  const Point spot = w.first(nearest);
  const Point g = unit(w.body.gradient(spot, w.parts));
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    const double r = length(w.first(v) - spot);
    if (panel[v] && r < radius) w.x[v] += (slope * (radius - r)) * g;
  }
}

// The arm is out of its sleeve, which hangs down behind it.
void empty_sleeve(Wearing& w, int side) {
  const std::vector<char> sleeve = w.of(side == 0 ? "sleeve_l" : "sleeve_r");
  const Frame& chest = w.body.bone(Bone::chest);
  const Part limb = arm(side);
  const Point hook =
      w.body.shoulder(side) + (0.065 * w.h) * chest.y - (0.01 * w.h * sign_of(side)) * chest.x;
  w.put(
      [&](std::size_t v) {
        const double s = w.body.along(limb, w.first(v));
        const Point r =
            w.body.bone(Bone::upper_arm_l, side)
                .local(w.first(v) + (w.body.shoulder(side) - w.body.axis_point(limb, w.first(v))));
        return hook + (0.8 * r[0]) * chest.x + (0.4 * r[1]) * chest.y - (s + r[2]) * chest.z;
      },
      [&](std::size_t v) {
        return sleeve[v] ? smooth_step(0.01 * w.h, 0.08 * w.h, w.body.along(limb, w.first(v))) : 0;
      });
  w.smooth(3, 0.5);
  w.parts &= ~static_cast<unsigned>(limb);
}

// Both legs are in one trouser leg; the other one hangs beside them.
void both_legs_in_one(Wearing& w, int side) {
  const int other = 1 - side;
  const Part full = leg(side), empty = leg(other);
  const double e = sign_of(other);
  w.put(
      [&](std::size_t v) {
        const Point p = w.first(v);
        const double x = p[0] - w.body.hip(0)[0] / 2 - w.body.hip(1)[0] / 2;
        const bool in_full = x * e < 0;
        const Part limb = in_full ? full : empty;
        const Point own = w.body.axis_point(limb, p), r = p - own;
        const Point opposite = w.body.axis_point(in_full ? empty : full, p);
        if (in_full) {
          // Offsets grow along x until the tube holds both axes.
          const double half = 0.5 * std::abs(opposite[0] - own[0]), radius = 0.07 * w.h;
          return Point{0.5 * (own[0] + opposite[0]) + r[0] * (1 + half / radius),
                       0.5 * (own[1] + opposite[1]) + 1.15 * r[1], p[2]};
        }
        return Point{own[0] + e * 0.1 * w.h + 0.6 * r[0], own[1] + 0.3 * r[1] + 0.02 * w.h, p[2]};
      },
      [&](std::size_t v) {
        const double below = (w.hip_z() - w.first(v)[2]) / w.h;
        return smooth_step(0.03, 0.15, below);
      });
  w.smooth(6, 0.5);
}

// The strip of cloth between neck and armhole lies below the armpit: the neck opening holds head
// and arm.
void arm_through_neck(Wearing& w, int side) {
  const Frame& chest = w.body.bone(Bone::chest);
  const double e = sign_of(side), h = w.h, t = w.t;
  const std::string name = side == 0 ? "sleeve_l" : "sleeve_r";
  const std::vector<char> sleeve = w.of(name);
  const Part limb = arm(side);
  const double armpit = 0.16 * t;  // in the chest, well below the arm
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    const Point q = chest.local(w.first(v));
    const double out = e * q[0] / h;
    if (sleeve[v]) {
      // Empty, down the side of the trunk.
      const double s = std::max(0.0, w.body.along(limb, w.first(v)));
      const Point r = w.first(v) - w.body.axis_point(limb, w.first(v));
      const double wide = 0.45 * dot(r, chest.y);
      w.x[v] = chest.world({e * (0.1 * h + 0.015 * h * smooth_step(0, 0.1 * h, s)), 0.01 * h + wide,
                            armpit - 0.02 * h - 0.85 * s});
      continue;
    }
    // From the neck, cloth above this line goes below it.
    const double line = 0.5 * t + (armpit - 0.5 * t) * smooth_step(0.01, 0.05, out);
    if (out < 0.005 || q[2] < armpit - 0.15 * t) continue;
    const double room = 0.1 * t;
    const double above = q[2] - (line - room);
    const double z = above > 0 ? line - room + room * (1 - std::exp(-above / room)) : q[2];
    // What was on top of the shoulder goes to the side, under the arm.
    const double x = q[0] + smooth_step(0.1 * t, 0.35 * t, above) * (e * 0.12 * h - q[0]);
    w.x[v] = chest.world({x, q[1], z});
  }
  for (std::size_t v = 0; v < w.x.size(); ++v)
    if (!sleeve[v] && e * chest.local(w.first(v))[0] > 0) w.keep_level(v, trunk | legs);
  w.smooth(2, 0.3);
}

// The garment rolls over the shoulders: the head is in an armhole, an arm in the neck opening.
void roll(Wearing& w, int side, double angle) {
  const Frame& chest = w.body.bone(Bone::chest);
  const Point centre = chest.world({0, 0, 0.05 * w.t});
  const double e = sign_of(side);
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    const Point q = w.first(v);
    const double share = smooth_step(w.hip_z() + 0.3 * w.t, w.hip_z() + 0.75 * w.t, q[2]);
    // About the axis to the back, positive from x to -z: the shoulder of `side` goes up.
    w.x[v] = centre + turned(q - centre, chest.y, -e * angle * share);
  }
  const unsigned all = trunk | head | arm(1 - side);
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    const bool low = chest.local(w.x[v])[2] < 0.3 * w.t;
    w.keep_level(v, low ? static_cast<unsigned>(trunk | legs) : all);
    w.keep_level(v, low ? static_cast<unsigned>(trunk | legs) : all);
  }
  w.parts = trunk | legs;
  w.smooth(2, 0.3);
}

// Neck and shoulders of the garment slide down over the shoulders.
void below_shoulders(Wearing& w, double amount) {
  w.flow(
      [&](std::size_t v, Point p) {
        const double share = smooth_step(w.hip_z(), w.hip_z() + 0.75 * w.t, w.first(v)[2]);
        if (w.body.nearest_part(p, w.parts) & arms) {
          const Part limb = w.body.nearest_part(p, w.parts);
          return amount * w.body.axis_direction(limb, p);
        }
        return (amount * std::max(share, 0.35)) * downhill(w, p);
      },
      16);
}

// A skirt is turned up over the waist, inside out.
void skirt_up(Wearing& w, double share) {
  double top = 0, low = 9;
  for (const Point& p : w.x) {
    top = std::max(top, p[2]);
    low = std::min(low, p[2]);
  }
  const Point axis = w.body.bone(Bone::waist).o;
  const double fold = top - (1 - share) * (top - low);
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    const Point q = w.first(v);
    const double below = fold - q[2];
    if (below <= 0) continue;
    const double wider = 1 + 0.12 * smooth_step(0, 0.04, below);
    w.x[v] = {axis[0] + wider * (q[0] - axis[0]), axis[1] + wider * (q[1] - axis[1]),
              fold + 0.95 * below};
  }
  w.smooth(2, 0.3);
  w.parts = trunk | legs;
}

// A heap on the floor.
void on_floor(Wearing& w, double beside, double direction, Draw& draw) {
  Point middle{0, 0, 0};
  double low = 9;
  for (const Point& p : w.x) {
    middle += (1.0 / static_cast<double>(w.x.size())) * p;
    low = std::min(low, p[2]);
  }
  const double a = draw.between(0, 6), k = draw.between(9, 14);
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    const Point q = w.first(v);
    const double spin = 2 * (q[2] - low);
    const Point r = turned({q[0] - middle[0], q[1] - middle[1], 0}, {0, 0, 1}, spin);
    w.x[v] = {r[0] + beside * std::cos(direction), r[1] + beside * std::sin(direction),
              0.01 + 0.14 * (q[2] - low) + 0.02 * (1 + std::sin(k * q[0] + a))};
  }
  w.parts = 0;
}

void move_away(Wearing& w, Point by) {
  for (Point& p : w.x) p += by;
  w.parts = 0;
}

// The crotch of briefs goes around a leg: both legs are in one leg opening.
void crotch_beside_leg(Wearing& w, int side) {
  const double e = sign_of(side);
  const double crotch = w.hip_z() - 0.06 * w.h;
  w.put(
      [&](std::size_t v) {
        const Point q = w.first(v);
        return Point{q[0] + e * 0.125 * w.h, q[1], q[2] + 0.02 * w.h};
      },
      [&](std::size_t v) {
        const Point q = w.first(v);
        return smooth_step(crotch + 0.075 * w.h, crotch + 0.005 * w.h, q[2]) *
               smooth_step(0.09 * w.h, 0.04 * w.h, std::abs(q[0]));
      });
  for (std::size_t v = 0; v < w.x.size(); ++v) w.keep_level(v, trunk | legs);
  w.smooth(2, 0.4);
}

// The upper part is stripped off and hangs from the waist.
void stripped(Wearing& w) {
  const double waist = w.hip_z() + 0.35 * w.t;
  const Point axis = w.body.bone(Bone::waist).o;
  for (int side = 0; side < 2; ++side) {
    const std::vector<char> sleeve = w.of(side == 0 ? "sleeve_l" : "sleeve_r");
    const Point root = w.body.shoulder(side);
    for (std::size_t v = 0; v < w.x.size(); ++v)
      if (sleeve[v]) {
        const double s = w.body.along(arm(side), w.first(v));
        const Point r = w.first(v) - w.body.axis_point(arm(side), w.first(v));
        // As if the arm pointed up: the fold below turns it down.
        w.x[v] = root + Point{0.5 * r[0], 0.5 * r[1], 0.7 * s + 0.2 * r[2]};
      }
  }
  for (Point& q : w.x) {
    const double above = q[2] - waist;
    if (above <= 0) continue;
    const double wider = 1 + 0.6 * smooth_step(0, 0.05, above);
    q = {axis[0] + wider * (q[0] - axis[0]), axis[1] + wider * (q[1] - axis[1]),
         waist - 0.9 * above};
  }
  w.parts = trunk | legs;
  w.smooth(3, 0.3);
}

// Back to front, each sleeve on the other arm.
void back_to_front(Wearing& w) {
  const Point axis = w.body.bone(Bone::chest).o;
  for (Point& p : w.x) p = {2 * axis[0] - p[0], 2 * axis[1] - p[1], p[2]};
  for (int round = 0; round < 3; ++round)
    for (std::size_t v = 0; v < w.x.size(); ++v) w.keep_level(v, w.parts);
}

// A collar is pulled up over the face, and the shirt with it.
void collar_up(Wearing& w, double amount) {
  const Frame& chest = w.body.bone(Bone::chest);
  w.parts |= head;
  w.flow(
      [&](std::size_t v, Point) {
        const Point q = chest.local(w.first(v));
        const double share = smooth_step(0.1 * w.t, 0.52 * w.t, q[2]) *
                             smooth_step(0.09 * w.h, 0.05 * w.h, std::hypot(q[0], q[1]));
        return (amount * share) * chest.z;
      },
      10);
  w.smooth(2, 0.3);
}

// A sleeve is turned back over itself, inside out.
void sleeve_inside_out(Wearing& w, int side) {
  const std::vector<char> sleeve = w.of(side == 0 ? "sleeve_l" : "sleeve_r");
  const Part limb = arm(side);
  double end = 0;
  for (std::size_t v = 0; v < w.x.size(); ++v)
    if (sleeve[v]) end = std::max(end, w.body.along(limb, w.first(v)));
  const double fold = 0.35 * end;
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    if (!sleeve[v]) continue;
    const double s = w.body.along(limb, w.first(v));
    if (s <= fold) continue;
    const Point axis = w.body.axis_point(limb, w.first(v));
    const Point direction = w.body.axis_direction(limb, w.first(v));
    const double back = fold - 0.55 * (s - fold);
    const Point r = w.first(v) - axis;
    w.x[v] =
        w.body.shoulder(side) + back * w.body.axis_direction(limb, w.body.shoulder(side)) +
        (1 + 0.35 * smooth_step(0, 0.03 * w.h, s - fold)) * (r - dot(r, direction) * direction);
  }
  w.smooth(2, 0.3);
}

// Part of a sleeve or leg is stretched lengthwise.
void drawn_out(Wearing& w, Part limb, const std::string& label, double from, double to,
               double stretch) {
  const std::vector<char> tube = w.of(label, limb);
  w.flow(
      [&](std::size_t v, Point p) {
        if (!tube[v]) return Point{0, 0, 0};
        const double s = w.body.along(limb, w.first(v));
        const double more = (stretch - 1) * (std::clamp(s, from, to) - from);
        return more * w.body.axis_direction(limb, p);
      },
      10);
}

// -------------------------------------------------------------------------------------- settings

Proportions person(int kind, Draw& draw) {
  Proportions p;
  switch (kind % 6) {
    case 0:
      break;
    case 1:  // tall and slim
      p.height = 1.9, p.girth = 0.92, p.limbs = 0.9, p.breast = {0, 0}, p.hip_height = 0.525;
      break;
    case 2:  // short and stout
      p.height = 1.58, p.girth = 1.32, p.limbs = 1.15, p.belly = 1, p.hip_height = 0.5;
      break;
    case 3:  // a child
      p.height = 1.12, p.head = 1.4, p.hip_height = 0.46, p.breast = {0, 0}, p.girth = 1.08;
      p.belly = 0.4;
      break;
    case 4:  // wide hips, one side larger
      p.height = 1.66, p.breast = {1, 0.8}, p.buttock = {1.15, 1.05}, p.girth = 1.05;
      break;
    default:  // broad shoulders
      p.height = 1.83, p.shoulders = 1.15, p.girth = 1.1, p.limbs = 1.1, p.breast = {0.3, 0.3};
      break;
  }
  p.height *= draw.between(0.97, 1.03);
  p.girth *= draw.between(0.97, 1.03);
  p.buttock[1] *= draw.between(0.95, 1.05);
  return p;
}

Pose pose(int kind, Draw& draw) {
  Pose p;
  switch (kind % 7) {
    case 0:
      break;  // A
    case 1:
      p.arm_raise = {86, 86};
      break;  // T
    case 2:
      p.elbow = {8, 70};
      break;  // an arm bent
    case 3:
      p.leg_forward = {18, -12}, p.knee = {6, 14};
      break;  // a step
    case 4:
      p.trunk_turn = 22;
      break;  // turned
    case 5:
      p.arm_raise = {24, 24}, p.leg_spread = {5, 5};
      break;  // arms hang
    default:
      p.arm_raise = {145, 145}, p.elbow = {0, 0};
      break;  // overhead
  }
  for (double& a : p.arm_raise) a += draw.between(-3, 3);
  return p;
}

bool tight(Cut c) {
  return c == Cut::briefs || c == Cut::pencil_skirt || c == Cut::strapless_dress;
}

Setting setting(Cut cut, int person_kind, int start, int end, double ease, Draw& draw) {
  Setting s;
  s.cut = cut;
  s.proportions = person(person_kind, draw);
  s.start = pose(start, draw);
  s.end = pose(end, draw);
  s.moved = start != end;
  const double scale = s.proportions.height / 1.72;
  s.how.ease = ease * (tight(cut) ? 0.5 : 1) * scale;
  s.how.edge = draw.between(0.05, 0.06) * scale * (cut == Cut::briefs ? 0.7 : 1);
  s.how.length = draw.between(0.93, 1.05);
  return s;
}

const char* name_of(Cut c) {
  constexpr std::array names{
      "T-shirt",          "long-sleeved shirt", "vest",       "turtleneck", "hoody, hood up",
      "hoody, hood down", "jumpsuit",           "trousers",   "shorts",     "pencil skirt",
      "wide skirt",       "strapless dress",    "long dress", "briefs",     "poncho"};
  return names[static_cast<std::size_t>(c)];
}

// Moves body and garment to another place in the world, as scenes may.
void place(SculptedFit& fit, Draw& draw, bool y_up) {
  const double yaw = draw.between(-3, 3);
  const Point shift{draw.between(-2, 2), draw.between(-2, 2), draw.between(0, 0.5)};
  const auto placed = [&](std::vector<Point>& points) {
    for (Point& p : points) {
      p = turned(p, {0, 0, 1}, yaw) + shift;
      if (y_up) p = {p[0], p[2], -p[1]};
    }
  };
  placed(fit.cloth.positions);
  placed(fit.cloth_start);
  placed(fit.body.positions);
  placed(fit.body_start);
  if (y_up) fit.up = {0, 1, 0};
}

SculptedFit finished(Wearing& w, const std::string& happened, bool with_start, bool moved,
                     Draw& draw) {
  SculptedFit fit;
  fit.what = std::string(name_of(w.garment.cut)) + ": " + happened;
  fit.with_cloth_start = with_start;
  fit.with_body_start = moved;
  fit.cloth.positions = w.x;
  fit.cloth.triangles = w.garment.triangles;
  fit.cloth.group = w.garment.group;
  fit.cloth.group_names = w.garment.names;
  fit.cloth_start = w.garment.positions;
  const SmoothField field = [&](Point p, Point* gradient) {
    return w.body.distance(p, whole_body, gradient);
  };
  Point low, high;
  w.body.bounds(whole_body, low, high);
  const Frame lattice = Frame{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}.rotated(
      unit({0.2, 0.1, 1}), draw.between(0, 1));
  LevelSurface skin;
  // Where a hand is thinner than the lattice, its tip comes off: a finer one keeps it.
  for (int finer = 0; finer < 4; ++finer) {
    skin = polygonised(field, low, high, std::pow(0.9, finer) * 0.0265 * w.h, lattice);
    const std::size_t whole = skin.triangles.size();
    skin.remove(0);
    if (skin.triangles.size() == whole) break;
  }
  even_out(skin, field, 3, 0, draw);
  fit.body.triangles = skin.triangles;
  fit.body_start = skin.positions;
  fit.body.positions = skin.positions;
  if (moved)
    for (Point& p : fit.body.positions) p = w.body.carried(p, w.body.weights(p), w.to);
  place(fit, draw, draw.between(0, 1) < 0.25);
  return fit;
}

}  // namespace

SculptedFit sculpted_good(int set, int n) {
  Draw draw(static_cast<std::uint64_t>(1000 * set + n + 1));
  // Poses: 0 A, 1 T, 2 an arm bent, 3 a step, 4 turned, 5 arms hang, 6 overhead.
  struct Row {
    Cut cut;
    int person, start, end;
    double ease;
  };
  static constexpr std::array<std::array<Row, fits_in_set>, 2> rows{
      {{{{Cut::tshirt, 2, 0, 0, 0.016},
         {Cut::long_shirt, 0, 0, 2, 0.028},
         {Cut::vest, 1, 0, 4, 0.03},
         {Cut::turtleneck, 4, 0, 5, 0.01},
         {Cut::hoody_up, 3, 5, 5, 0.022},
         {Cut::hoody_down, 5, 0, 3, 0.03},
         {Cut::jumpsuit, 1, 0, 3, 0.022},
         {Cut::trousers, 2, 1, 0, 0.02},
         {Cut::shorts, 5, 6, 6, 0.025},
         {Cut::pencil_skirt, 4, 0, 0, 0.014},
         {Cut::wide_skirt, 0, 0, 3, 0.016},
         {Cut::strapless_dress, 4, 1, 1, 0.014},
         {Cut::long_dress, 3, 0, 5, 0.02},
         {Cut::briefs, 3, 0, 3, 0.026},
         {Cut::poncho, 0, 5, 5, 0.02}}},
       {{{Cut::tshirt, 5, 1, 0, 0.03},
         {Cut::long_shirt, 3, 1, 1, 0.016},
         {Cut::vest, 4, 5, 5, 0.014},
         {Cut::turtleneck, 1, 4, 4, 0.012},
         {Cut::hoody_up, 0, 0, 4, 0.03},
         {Cut::hoody_down, 2, 5, 5, 0.022},
         {Cut::jumpsuit, 4, 0, 0, 0.016},
         {Cut::trousers, 1, 0, 3, 0.03},
         {Cut::shorts, 3, 0, 3, 0.018},
         {Cut::pencil_skirt, 0, 5, 4, 0.02},
         {Cut::wide_skirt, 2, 1, 1, 0.016},
         {Cut::strapless_dress, 1, 0, 2, 0.018},
         {Cut::long_dress, 5, 1, 1, 0.018},
         {Cut::briefs, 2, 1, 1, 0.02},
         {Cut::poncho, 4, 5, 4, 0.016}}}}};
  const Row& row = rows[static_cast<std::size_t>(set % 2)][static_cast<std::size_t>(n)];
  const int person_kind = set < 2 ? row.person : static_cast<int>(draw.between(0, 6));
  Setting s = setting(row.cut, person_kind, row.start, row.end, row.ease, draw);
  s.how.split_tubes = n % 2 == 1;
  s.how.unnamed = (n + set) % 4 == 3;
  Wearing w(s, draw);
  // Never the bent arm: a sleeve that is pushed over a bent elbow is stretched.
  const int side = draw.between(0, 1) < 0.5 || s.end.elbow[1] > 30 ? 0 : 1;
  const double sign = sign_of(side), share = draw.between(0.5, 0.6);
  const double sag = share * trunk_limit * w.h, slip = share * limb_limit * w.h;
  std::string happened;
  switch (row.cut) {
    case Cut::tshirt:
    case Cut::vest:
    case Cut::turtleneck:
      happened = "sags and is pulled a little";
      slide_down(w, 0.4 * sag, w.hip_z() - 0.4 * w.t);
      break;
    case Cut::long_shirt:
    case Cut::hoody_down:
    case Cut::jumpsuit:
      happened = "a sleeve is pushed up a little";
      slide_tube(w, arm(side), side == 0 ? "sleeve_l" : "sleeve_r", -slip);
      break;
    case Cut::hoody_up:
    case Cut::long_dress:
      happened = "a sleeve is twisted a little";
      twist_tube(w, arm(side), side == 0 ? "sleeve_l" : "sleeve_r", sign * share * turn_limit);
      break;
    case Cut::trousers:
    case Cut::shorts:
    case Cut::briefs:
      happened = "sags";
      slide_down(w, sag, w.hip_z() - (row.cut == Cut::trousers ? 0.4 : 0.15) * w.h);
      break;
    case Cut::pencil_skirt:
    case Cut::wide_skirt:
    case Cut::poncho:
      happened = "is turned a little";
      turn(w, sign * share * turn_limit);
      break;
    case Cut::strapless_dress:
      happened = "slid down a little";
      slide_down(w, sag, 0.2 * w.h);
      break;
  }
  w.carry();
  w.wrinkle(draw.between(0.002, 0.005) * w.h / 1.72, draw);
  w.relax_until_slack(24);
  if (happened == "sags and is pulled a little") pull(w, "front", 0.1 * w.h / 1.72, 0.3);
  if (s.moved) happened += ", and the body moved";
  return finished(w, happened, n % 5 != 4, s.moved, draw);
}

SculptedFit sculpted_bad(int set, int n) {
  Draw draw(static_cast<std::uint64_t>(1000 * set + n + 501));
  enum class Fault {
    empty_sleeve,
    both_legs,
    arm_through_neck,
    rolled,
    below_shoulders,
    slid,
    turned,
    sleeve_up,
    leg_twisted,
    skirt_up,
    pulled,
    floor,
    crotch,
    stripped,
    beside,
    reversed,
    collar_up,
    inside_out,
    drawn_out
  };
  struct Row {
    Fault fault;
    Cut cut;
    int person, start, end;
    double ease;
  };
  using F = Fault;
  static constexpr std::array<std::array<Row, fits_in_set>, 2> rows{
      {{{{F::empty_sleeve, Cut::long_shirt, 0, 0, 0, 0.02},
         {F::both_legs, Cut::trousers, 1, 0, 0, 0.035},
         {F::arm_through_neck, Cut::tshirt, 4, 0, 0, 0.025},
         {F::rolled, Cut::vest, 1, 0, 0, 0.03},
         {F::below_shoulders, Cut::long_shirt, 2, 0, 4, 0.025},
         {F::slid, Cut::shorts, 5, 1, 0, 0.04},
         {F::turned, Cut::pencil_skirt, 0, 0, 5, 0.04},
         {F::sleeve_up, Cut::turtleneck, 3, 1, 1, 0.014},
         {F::leg_twisted, Cut::trousers, 4, 0, 3, 0.025},
         {F::skirt_up, Cut::wide_skirt, 0, 6, 6, 0.016},
         {F::pulled, Cut::tshirt, 5, 0, 0, 0.02},
         {F::floor, Cut::long_dress, 3, 5, 5, 0.02},
         {F::crotch, Cut::briefs, 4, 0, 0, 0.014},
         {F::stripped, Cut::jumpsuit, 1, 0, 0, 0.022},
         {F::slid, Cut::strapless_dress, 2, 0, 2, 0.014}}},
       {{{F::empty_sleeve, Cut::hoody_down, 5, 0, 4, 0.025},
         {F::both_legs, Cut::jumpsuit, 0, 1, 1, 0.03},
         {F::arm_through_neck, Cut::long_shirt, 1, 1, 1, 0.025},
         {F::rolled, Cut::poncho, 0, 5, 5, 0.02},
         {F::below_shoulders, Cut::tshirt, 5, 1, 1, 0.03},
         {F::slid, Cut::trousers, 3, 0, 3, 0.035},
         {F::turned, Cut::wide_skirt, 2, 0, 4, 0.016},
         {F::sleeve_up, Cut::hoody_up, 4, 0, 2, 0.022},
         {F::beside, Cut::tshirt, 1, 5, 5, 0.02},
         {F::reversed, Cut::tshirt, 0, 0, 0, 0.025},
         {F::collar_up, Cut::turtleneck, 5, 0, 0, 0.014},
         {F::inside_out, Cut::tshirt, 3, 1, 1, 0.016},
         {F::drawn_out, Cut::long_shirt, 2, 0, 5, 0.018},
         {F::floor, Cut::trousers, 4, 0, 0, 0.02},
         {F::leg_twisted, Cut::jumpsuit, 5, 0, 0, 0.022}}}}};
  const Row& row = rows[static_cast<std::size_t>(set % 2)][static_cast<std::size_t>(n)];
  const int person_kind = set < 2 ? row.person : static_cast<int>(draw.between(0, 6));
  Setting s = setting(row.cut, person_kind, row.start, row.end, row.ease, draw);
  s.how.split_tubes = n % 2 == 0;
  s.how.unnamed = (n + set) % 4 == 1;
  if (row.fault == F::both_legs) {
    s.end.leg_spread = {2.5, 2.5};
    s.moved = true;
  }
  Wearing w(s, draw);
  const int side = draw.between(0, 1) < 0.5 ? 0 : 1;
  const double sign = sign_of(side), times = draw.between(1.3, 1.8);
  const std::string sleeve = side == 0 ? "sleeve_l" : "sleeve_r";
  std::string happened, fault;
  int rounds = 25;
  bool slack = false;  // what happened needs no stretch
  bool with_start = true;
  switch (row.fault) {
    case F::empty_sleeve:
      happened = "a sleeve is off its arm";
      fault = "around nothing, not the arm";
      empty_sleeve(w, side);
      break;
    case F::both_legs:
      happened = "both legs in one trouser leg";
      fault = "not the leg";
      both_legs_in_one(w, side);
      slack = true;
      break;
    case F::arm_through_neck:
      happened = "an arm through the neck opening";
      fault = "around the trunk, the arm";
      arm_through_neck(w, side);
      break;
    case F::rolled:
      happened = "head and neck opening do not belong together";
      fault = ", not the trunk";
      roll(w, side, 44 * degree);
      break;
    case F::below_shoulders:
      happened = "hangs below the shoulders";
      fault = "has slid";
      below_shoulders(w, (times + 1.2) * trunk_limit * w.h);
      slack = true;
      break;
    case F::slid:
      happened = "slid down";
      fault = "has slid";
      slack = true;
      slide_down(w, (times + 0.2) * trunk_limit * w.h,
                 row.cut == Cut::shorts ? 0.25 * w.h : 0.08 * w.h);
      break;
    case F::turned:
      happened = "turned about the body";
      fault = "has turned";
      turn(w, sign * times * turn_limit);
      slack = true;
      break;
    case F::sleeve_up:
      happened = "a sleeve is pushed up";
      fault = "has slid";
      slide_tube(w, arm(side), sleeve, -times * limb_limit * w.h);
      slack = true;
      break;
    case F::leg_twisted:
      happened = "a trouser leg is twisted";
      fault = "has turned";
      twist_tube(w, leg(side), "leg", sign * times * turn_limit);
      slack = true;
      break;
    case F::skirt_up:
      happened = "turned up inside out";
      fault = "is inside out";
      skirt_up(w, 0.85);
      break;
    case F::pulled:
      happened = "stretched where it is pulled";
      fault = "is stretched";
      pull(w, "front", 0.11 * w.h / 1.72, 1.1);
      rounds = 0;
      break;
    case F::floor:
      happened = "a heap on the floor";
      fault = "no opening is around";
      on_floor(w, 0.35 * w.h, draw.between(-3, 3), draw);
      with_start = set == 1;
      break;
    case F::crotch:
      happened = "both legs in one leg opening";
      fault = "not the leg";
      crotch_beside_leg(w, side);
      break;
    case F::stripped:
      happened = "its upper part is stripped to the waist";
      fault = "is inside out";
      stripped(w);
      break;
    case F::beside:
      happened = "floats beside the body";
      fault = "no opening is around";
      move_away(w, {sign * 0.5 * w.h, 0.1 * w.h, -0.05 * w.h});
      break;
    case F::reversed:
      happened = "back to front";
      fault = "has turned";
      back_to_front(w);
      break;
    case F::collar_up:
      happened = "its collar is pulled over the head";
      fault = "has slid";
      collar_up(w, (times + 0.5) * trunk_limit * w.h);
      rounds = 4;
      break;
    case F::inside_out:
      happened = "a sleeve is turned back to the shoulder, inside out";
      fault = "has slid";
      sleeve_inside_out(w, side);
      break;
    case F::drawn_out:
      happened = "a sleeve is drawn out";
      fault = "is stretched";
      drawn_out(w, arm(side), sleeve, 0.1 * w.h, 0.2 * w.h, 1 + 0.25 * times);
      rounds = 0;
      break;
  }
  w.carry();
  w.wrinkle(draw.between(0.002, 0.005) * w.h / 1.72, draw);
  if (slack)
    w.relax_until_slack(8);
  else
    w.relax(rounds);
  if (s.moved) happened += ", and the body moved";
  SculptedFit fit = finished(w, happened, with_start, s.moved, draw);
  fit.fault = fault;
  return fit;
}

SculptedFit sculpted_motion(Motion motion) {
  Draw draw(static_cast<std::uint64_t>(motion) + 90001);
  const bool legs_move = motion == Motion::steps_wide;
  Setting s = setting(legs_move ? Cut::trousers : Cut::long_shirt, 0, 0, 0, 0.03, draw);
  s.moved = true;
  std::string happened;
  switch (motion) {
    case Motion::reaches_forward:
      happened = "the body reaches forward";
      s.end.arm_raise = {10, 10};
      s.end.arm_forward = {60, 65};
      break;
    case Motion::turns_trunk:
      happened = "the body turns its trunk";
      s.end.trunk_turn = 65;
      break;
    case Motion::steps_wide:
      happened = "the body takes a wide step";
      s.end.leg_forward = {38, -25};
      s.end.knee = {15, 30};
      break;
    case Motion::bends_arms:
      happened = "the body bends both arms";
      s.end.elbow = {95, 100};
      break;
  }
  Wearing w(s, draw);
  w.carry();
  w.wrinkle(0.003, draw);
  w.relax_until_slack(24);
  return finished(w, happened, true, true, draw);
}

SculptedFit sculpted_hitched(double share) {
  Draw draw(90010);
  const Setting s = setting(Cut::long_dress, 4, 0, 0, 0.02, draw);
  Wearing w(s, draw);
  double low = 9;
  for (const Point& p : w.x) low = std::min(low, p[2]);
  const double waist = w.hip_z() + 0.4 * w.t;
  const std::vector<char> sleeves = w.of("sleeve");
  for (std::size_t v = 0; v < w.x.size(); ++v) {
    const double below = std::clamp((waist - w.first(v)[2]) / (waist - low), 0.0, 1.0);
    if (sleeves[v] == 0) w.x[v][2] += share * w.h * below;
  }
  w.wrinkle(0.006, draw);
  w.relax_until_slack(8);
  return finished(w, "its hem is hitched up", true, false, draw);
}

SculptedFit sculpted_long_trousers() {
  Draw draw(90020);
  Setting s = setting(Cut::trousers, 0, 0, 0, 0.05, draw);
  s.how.length = 1.17;
  Wearing w(s, draw);
  for (Point& p : w.x) p[2] -= 0.02 * w.h * smooth_step(0.3 * w.h, 0.05 * w.h, p[2]);
  w.wrinkle(0.003, draw);
  return finished(w, "its legs hang below the soles", true, false, draw);
}

}  // namespace weft::lab::test
