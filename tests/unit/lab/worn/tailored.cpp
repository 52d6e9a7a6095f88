#include "tests/unit/lab/worn/tailored.hpp"

#include <algorithm>
#include <cmath>

#include "weft/core/at.hpp"

namespace weft::lab::test {
namespace {

enum Bit { hem, neck, end_l, end_r, armhole_l, armhole_r, coronal, sagittal, collar, hood, band };

bool has(unsigned sides, int bit) {
  return (sides >> bit & 1u) != 0;
}

bool has_sleeves(Cut c) {
  return c == Cut::tshirt || c == Cut::long_shirt || c == Cut::turtleneck || c == Cut::hoody_up ||
         c == Cut::hoody_down || c == Cut::jumpsuit || c == Cut::long_dress;
}

bool is_hoody(Cut c) {
  return c == Cut::hoody_up || c == Cut::hoody_down;
}

bool has_neck(Cut c) {
  return has_sleeves(c) || c == Cut::vest || c == Cut::poncho;
}

bool has_legs(Cut c) {
  return c == Cut::trousers || c == Cut::shorts || c == Cut::jumpsuit;
}

bool has_waistband(Cut c) {
  return c == Cut::trousers || c == Cut::shorts || c == Cut::pencil_skirt || c == Cut::wide_skirt;
}

unsigned parts_of(Cut c) {
  unsigned parts = trunk;
  if (has_sleeves(c) || c == Cut::vest || c == Cut::poncho) parts |= arms;
  if (is_hoody(c)) parts |= head;
  if (c != Cut::poncho) parts |= legs;
  return parts;
}

// Adds the cone of a garment that stands away from the body. Lengths below the hips are shares of
// the body's height.
void add_shell(Cut cut, Sculpture& shell, const Tailoring& how) {
  const double h = shell.height(), t = shell.trunk_length();
  const double l = how.length;
  switch (cut) {
    case Cut::pencil_skirt:
      shell.add_cone(Bone::pelvis, 0.25 * t, -0.24 * l * h, 0.06 * h, 0.108 * h, 0.7);
      break;
    case Cut::wide_skirt:
      shell.add_cone(Bone::pelvis, 0.45 * t, -0.26 * l * h, 0.06 * h, 0.22 * h, 0.85);
      break;
    case Cut::strapless_dress:
      shell.add_cone(Bone::pelvis, 0.4 * t, -0.2 * l * h, 0.06 * h, 0.15 * h, 0.75);
      break;
    case Cut::long_dress:
      shell.add_cone(Bone::pelvis, 0.4 * t, -0.38 * l * h, 0.06 * h, 0.19 * h, 0.8);
      break;
    case Cut::poncho:
      shell.add_cone(Bone::chest, 0.5 * t, -0.6 * t, 0.05 * h, 0.31 * h, 0.55);
      break;
    default:
      break;
  }
}

// Height of the lower edge of what covers the trunk.
double hem_z(Cut cut, const Sculpture& body, double l) {
  const double h = body.height(), t = body.trunk_length(), z = body.hip_z();
  switch (cut) {
    case Cut::pencil_skirt:
      return z - 0.21 * l * h;
    case Cut::wide_skirt:
      return z - 0.22 * l * h;
    case Cut::strapless_dress:
      return z - 0.17 * l * h;
    case Cut::long_dress:
      return z - 0.34 * l * h;
    case Cut::poncho:
      return z + 0.12 * t;
    case Cut::vest:
      return z + 0.1 * t;
    default:
      return z + (0.12 - 0.14 * l) * t;
  }
}

// Height of the upper edge of what has no neckline.
double waist_z(Cut cut, const Sculpture& body) {
  const double t = body.trunk_length(), z = body.hip_z();
  switch (cut) {
    case Cut::wide_skirt:
      return z + 0.46 * t;
    case Cut::pencil_skirt:
      return z + 0.4 * t;
    case Cut::strapless_dress:
      return z + 0.75 * t;
    case Cut::briefs:
      return z + 0.2 * t;
    default:
      return z + 0.32 * t;
  }
}

// Turns the hood about the nape of the neck until it hangs down the back.
void fold_hood(std::vector<Point>& positions, const Sculpture& body) {
  const double h = body.height(), t = body.trunk_length();
  const Frame& chest = body.bone(Bone::chest);
  const Point nape = chest.world({0, 0.03 * h, 0.54 * t});
  for (Point& p : positions) {
    const double w = smooth_step(0.5 * t, 0.78 * t, chest.local(p)[2]);
    const Point q = p - nape;
    p = nape + (1 - 0.25 * w) * turned(q, chest.x, -2.2 * w);
  }
  for (int round = 0; round < 3; ++round)
    for (Point& p : positions) {
      const double d = body.distance(p, trunk | arms);
      if (d < 0.012) p += (0.012 - d) * unit(body.gradient(p, trunk | arms));
    }
}

std::string label(Cut cut, unsigned sides, const Tailoring& how) {
  const std::string half = has(sides, coronal) ? "back" : "front";
  const std::string side = has(sides, sagittal) ? "_l" : "_r";
  if (has_sleeves(cut))
    for (int s = 0; s < 2; ++s)
      if (has(sides, s == 0 ? armhole_l : armhole_r)) {
        const std::string sleeve = s == 0 ? "sleeve_l" : "sleeve_r";
        return how.split_tubes ? sleeve + "_" + half : sleeve;
      }
  if (is_hoody(cut) && has(sides, hood)) return "hood";
  if (cut == Cut::turtleneck && has(sides, collar)) return "collar";
  if (has_waistband(cut) && has(sides, band)) return "waistband";
  if (has_legs(cut)) {
    if (cut == Cut::jumpsuit && has(sides, band)) return half;
    if (how.split_tubes) return "leg_" + half + side;
    return "leg" + side;
  }
  return half;
}

}  // namespace

Tailored tailored(Cut cut, const Sculpture& body, const Tailoring& how, Draw& draw) {
  const double h = body.height(), t = body.trunk_length();
  Sculpture shell = body;
  add_shell(cut, shell, how);
  const unsigned covered = parts_of(cut), parts = covered | extra;
  const unsigned own = covered & whole_body;
  // Ease varies along the body.
  const Point wave{draw.between(-6, 6), draw.between(-6, 6), draw.between(-9, 9)};
  const double phase = draw.between(0, 6);
  const SmoothField field = [&](Point p, Point* gradient) {
    return shell.distance(p, parts, gradient) -
           how.ease * (1 + 0.3 * std::sin(dot(wave, p) + phase));
  };
  Point low, high;
  shell.bounds(parts, low, high);
  const Point margin{0.06, 0.06, 0.06};
  // Surfaces far above or below the garment would only be cut off again.
  if (!has_legs(cut) && cut != Cut::briefs) {
    double lowest = hem_z(cut, body, how.length);
    if (own & arms) lowest = std::min({lowest, body.wrist(0)[2], body.wrist(1)[2]});
    low[2] = std::max(low[2], lowest - 0.05);
  }
  if (!has_neck(cut)) high[2] = std::min(high[2], waist_z(cut, body) + 0.05);
  Frame lattice{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  lattice = lattice.rotated(unit({draw.between(-1, 1), draw.between(-1, 1), 1.2}),
                            draw.between(0.2, 1.2));
  LevelSurface surface = polygonised(field, low - margin, high + margin, how.edge, lattice);
  even_out(surface, field, 5, 0.15, draw);

  const Frame chest = body.bone(Bone::chest);
  const auto arm_or_negative = [&](Point p, double g) {
    return (body.nearest_part(p, own) & arms) ? -1.0 : g;
  };
  const auto around_neck = [&](double radius) {
    return [&, radius](Point p) {
      const Point q = chest.local(p);
      const double from_axis = std::hypot(q[0], q[1] + 0.006 * h);
      return std::min(radius * h - from_axis, q[2] - 0.3 * t);
    };
  };
  const double lower = hem_z(cut, body, how.length);
  if (!has_legs(cut) && cut != Cut::briefs)
    surface.cut(
        [&](Point p) {
          return cut == Cut::poncho ? lower - p[2] : arm_or_negative(p, lower - p[2]);
        },
        hem);
  if (!has_neck(cut)) {
    const double upper = waist_z(cut, body);
    surface.cut([&](Point p) { return p[2] - upper; }, neck);
    if (has_waistband(cut)) surface.cut([&](Point p) { return p[2] - upper + 0.025 * h; }, band);
  } else if (is_hoody(cut)) {
    const Point face = body.bone(Bone::head).world({0, -0.075 * h, 0.045 * h});
    surface.cut(
        [&](Point p) {
          const Point q = p - face;
          return 1 - std::hypot(q[0] / (0.05 * h), q[1] / (0.07 * h), q[2] / (0.07 * h));
        },
        neck);
    surface.cut(
        [&](Point p) { return std::max(around_neck(0.058)(p), chest.local(p)[2] - 0.64 * t); },
        hood);
  } else if (cut == Cut::turtleneck) {
    surface.cut([&](Point p) { return chest.local(p)[2] - 0.66 * t; }, neck);
    surface.cut(around_neck(0.05), collar);
  } else {
    surface.cut(around_neck(cut == Cut::vest ? 0.058 : cut == Cut::poncho ? 0.06 : 0.054), neck);
  }
  if (has_sleeves(cut) || cut == Cut::vest)
    for (int side = 0; side < 2; ++side) {
      const bool short_sleeve = cut == Cut::tshirt;
      const double end = (short_sleeve ? 0.12 : 0.3) * how.length * h;
      if (cut != Cut::vest)
        surface.cut(
            [&](Point p) {
              return body.nearest_part(p, own) == arm(side) ? body.along(arm(side), p) - end : -1.0;
            },
            end_l + side);
      const Point along = body.axis_direction(arm(side), body.shoulder(side));
      const double raised = std::max(0.0, dot(along, chest.z));
      const Point normal = unit(sign_of(side) * chest.x + (0.35 + 0.65 * raised) * along);
      const double inward = cut == Cut::vest ? 0.002 : 0.012;
      const Point place = body.shoulder(side) - inward * h * sign_of(side) * chest.x;
      const double reach = 0.058 * h + how.ease;
      surface.cut(
          [&](Point p) {
            const double from_axis = length(p - body.axis_point(arm(side), p));
            return std::min(dot(p - place, normal), reach - from_axis);
          },
          armhole_l + side);
    }
  if (has_legs(cut)) {
    const double leg_length = body.hip_z() - 0.045 * h;
    const double end = (cut == Cut::shorts ? 0.43 : 0.92) * how.length * leg_length;
    for (int side = 0; side < 2; ++side)
      surface.cut(
          [&](Point p) {
            return body.nearest_part(p, own) == leg(side) ? body.along(leg(side), p) - end : -1.0;
          },
          end_l + side);
    surface.cut([&](Point p) { return body.bone(Bone::pelvis).local(p)[0]; }, sagittal);
    if (cut == Cut::jumpsuit)
      surface.cut(
          [&](Point p) {
            return (body.nearest_part(p, own) & arms) ? 1.0 : p[2] - body.hip_z() - 0.4 * t;
          },
          band);
  }
  if (cut == Cut::briefs) {
    double crotch = 0;
    const Frame& pelvis = body.bone(Bone::pelvis);
    for (int step = 0; step < 100 && field(pelvis.world({0, 0, crotch}), nullptr) < 0; ++step)
      crotch -= 0.002 * h;
    for (int side = 0; side < 2; ++side) {
      const Point place = pelvis.world({sign_of(side) * 0.024 * h, 0, crotch});
      const Point normal = unit({sign_of(side), 0, -0.9});
      surface.cut([&](Point p) { return dot(p - place, normal); }, end_l + side);
    }
  }
  surface.cut([&](Point p) { return body.to_the_back(p) - 0.004 * h; }, coronal);
  unsigned removed = 1u << hem | 1u << neck | 1u << end_l | 1u << end_r;
  if (cut == Cut::vest) removed |= 1u << armhole_l | 1u << armhole_r;
  surface.remove(removed);

  Tailored made;
  made.cut = cut;
  made.parts = covered;
  made.positions = surface.positions;
  made.triangles = surface.triangles;
  if (cut == Cut::hoody_down) fold_hood(made.positions, body);
  for (const unsigned sides : surface.sides) {
    const std::string name = label(cut, sides, how);
    const auto found = std::find(made.labels.begin(), made.labels.end(), name);
    made.group.push_back(static_cast<Index>(found - made.labels.begin()));
    if (found == made.labels.end()) made.labels.push_back(name);
  }
  made.names = made.labels;
  if (how.unnamed)
    for (std::size_t i = 0; i < made.names.size(); ++i)
      made.names[i] = "panel_" + std::to_string(i);
  return made;
}

}  // namespace weft::lab::test
