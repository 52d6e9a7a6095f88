#include "host/adaptive/bending_cost.hpp"

#include <cmath>
#include <cstddef>
#include <limits>

#include "host/scene/fabric/rigidity.hpp"
#include "weft/core/at.hpp"
#include "weft/elements/hinge.hpp"

namespace weft {
namespace {

/// Corner of a triangle that a vertex is.
int corner_of(const Tri& t, Index v) {
  return t.v[0] == v ? 0 : t.v[1] == v ? 1 : 2;
}

}  // namespace

BendingLaws bending_laws(const Scene& scene) {
  BendingLaws laws{scene.bending, {}, {}};
  for (const Material& material : scene.materials) {
    laws.rigidity.push_back(bending_rigidity(material));
    laws.mean.push_back(mean_bending_stiffness(material));
  }
  return laws;
}

FreshTriangle BendingCost::there(Index t) const {
  return {m_.triangles[at(t)], m_.corners[at(t)], m_.kind[at(t)]};
}

/// Finds rings of triangles around some.
void BendingCost::gather(const std::vector<Index>& core, int rings) {
  taken_.resize(m_.triangles.size(), 0);
  rings_.clear();
  ring_end_.clear();
  for (const Index t : core) taken_[at(t)] = 1;
  const auto add_across = [&](Index t) {
    for (Index h = 3 * t; h < 3 * t + 3; ++h) {
      const Index g = m_.twin[at(h)];
      if (g < 0 || taken_[at(g / 3)] != 0) continue;
      taken_[at(g / 3)] = 1;
      rings_.push_back(g / 3);
    }
  };
  for (const Index t : core) add_across(t);
  ring_end_.push_back(rings_.size());
  for (std::size_t begin = 0; static_cast<int>(ring_end_.size()) < rings;) {
    const std::size_t end = rings_.size();
    for (; begin < end; ++begin) add_across(rings_[begin]);
    ring_end_.push_back(rings_.size());
  }
  for (const Index t : core) taken_[at(t)] = 0;
  for (const Index t : rings_) taken_[at(t)] = 0;
}

/// Energy of the edge from a to b of `front`, which `back` has the other way round. [J]
double BendingCost::hinge(Index a, Index b, const FreshTriangle& front,
                          const FreshTriangle& back) const {
  const int i = corner_of(front.tri, a), j = corner_of(back.tri, b);
  const auto along = [&](const FreshTriangle& t, int from) {
    return length(m_.material[at(t.corner.v[(from + 1) % 3])] - m_.material[at(t.corner.v[from])]);
  };
  const auto mean = [&](const FreshTriangle& t) {
    return laws_.mean[at(m_.kinds[at(t.kind)].material)];
  };
  const Vec3<double> x[4] = {m_.positions[at(a)], m_.positions[at(b)],
                             m_.positions[at(front.tri.v[(i + 2) % 3])],
                             m_.positions[at(back.tri.v[(j + 2) % 3])]};
  const double area = (m_.material_det(front.corner) + m_.material_det(back.corner)) / 2;
  return hinge_energy(x, 0.0,
                      hinge_coefficient((mean(front) + mean(back)) / 2,
                                        (along(front, i) + along(back, j)) / 2, area));
}

/// Of the edge of h. [J]
/// @pre it has a triangle on either side
double BendingCost::hinge_there(Index h) {
  if (hinge_.size() <= at(h))
    hinge_.resize(m_.twin.size(), std::numeric_limits<double>::quiet_NaN());
  double& known = hinge_[at(h)];
  if (std::isnan(known))
    known = hinge(m_.from(h), m_.to(h), there(h / 3), there(m_.twin[at(h)] / 3));
  return known;
}

/// Of the edges between triangles that are to come, and between these and the first ring. [J]
double BendingCost::hinges_of(const std::vector<FreshTriangle>& core) const {
  double sum = 0;
  const auto meet = [&](const FreshTriangle& s, const FreshTriangle& t) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (s.tri.v[i] == t.tri.v[(j + 1) % 3] && s.tri.v[(i + 1) % 3] == t.tri.v[j])
          sum += hinge(s.tri.v[i], t.tri.v[j], s, t);
  };
  for (std::size_t s = 0; s < core.size(); ++s) {
    for (std::size_t t = s + 1; t < core.size(); ++t) meet(core[s], core[t]);
    for (std::size_t r = 0; r < ring_end_[0]; ++r) meet(core[s], there(rings_[r]));
  }
  return sum;
}

/// Of the edges between triangles of the core, and between these and the first ring. [J]
double BendingCost::hinges_of(const std::vector<Index>& core) {
  double sum = 0;
  const auto meet = [&](Index s, Index t) {
    for (Index h = 3 * s; h < 3 * s + 3; ++h)
      if (const Index g = m_.twin[at(h)]; g >= 0 && g / 3 == t) sum += hinge_there(h);
  };
  for (std::size_t s = 0; s < core.size(); ++s) {
    for (std::size_t t = s + 1; t < core.size(); ++t) meet(core[s], core[t]);
    for (std::size_t r = 0; r < ring_end_[0]; ++r) meet(core[s], rings_[r]);
  }
  return sum;
}

/// Of the other edges of the first ring. [J]
/// @pre two rings have been gathered
double BendingCost::hinges_beyond() {
  double sum = 0;
  for (std::size_t r = 0; r < ring_end_[0]; ++r)
    for (Index h = 3 * rings_[r]; h < 3 * rings_[r] + 3; ++h) {
      const Index g = m_.twin[at(h)];
      if (g < 0) continue;
      for (std::size_t s = 0; s < ring_end_[1]; ++s)
        if (rings_[s] == g / 3 && (s > r || s >= ring_end_[0])) sum += hinge_there(h);
    }
  return sum;
}

void BendingCost::take(const FreshTriangle& triangle) {
  PlateTriangle plate{{}, {}, &laws_.rigidity[at(m_.kinds[at(triangle.kind)].material)], 0, true};
  for (std::size_t j = 0; j < 3; ++j) {
    const Index v = triangle.tri.v[j];
    // Vertices that seams have made one bend as one.
    const Index place = m_.place[at(v)];
    Index& number = number_[at(place)];
    if (number < 0) {
      number = static_cast<Index>(positions_.size());
      numbered_.push_back(place);
      positions_.push_back(m_.positions[at(v)]);
    }
    plate.v.v[j] = number;
    plate.source.v[j] = v;
    plate.rest[j] = m_.material[at(triangle.corner.v[j])];
    plate.held = plate.held && m_.hold[at(v)] != 0;
  }
  triangles_.push_back(plate);
}

PlateNote& BendingCost::note_of(Index t) {
  if (note_.size() <= at(t)) note_.resize(m_.triangles.size(), -1);
  if (note_[at(t)] < 0) {
    note_[at(t)] = static_cast<Index>(notes_.size());
    notes_.emplace_back().triangle = t;
  }
  PlateNote& note = notes_[at(note_[at(t)])];
  for (Index k = 0; k < 3; ++k)
    note.inner[static_cast<std::size_t>(k)] = m_.twin[at(3 * t + (k + 1) % 3)] >= 0;
  return note;
}

void BendingCost::forget(const std::vector<Index>& triangles) {
  const auto drop = [&](Index t) {
    if (at(t) < note_.size() && note_[at(t)] >= 0) notes_[at(note_[at(t)])].forget();
  };
  const auto drop_hinge = [&](Index h) {
    if (at(h) < hinge_.size()) hinge_[at(h)] = std::numeric_limits<double>::quiet_NaN();
  };
  for (const Index t : triangles) {
    drop(t);
    // What is gone still says what it met.
    for (Index h = 3 * t; h < 3 * t + 3; ++h) {
      drop_hinge(h);
      if (const Index g = m_.twin[at(h)]; g >= 0) {
        drop(g / 3);
        drop_hinge(g);
      }
    }
  }
}

/// Of the core and of the first ring. [J]
/// @param numbers of the core's triangles; null: they are not there, and what is there next to
///                them would be another then
/// @pre three rings have been gathered
double BendingCost::plates_of(const std::vector<FreshTriangle>& core,
                              const std::vector<Index>* numbers) {
  patch_notes_.clear();
  for (std::size_t k = 0; k < core.size(); ++k)
    patch_notes_.push_back(numbers != nullptr ? &note_of((*numbers)[k]) : nullptr);
  for (std::size_t r = 0; r < rings_.size(); ++r)
    patch_notes_.push_back(numbers != nullptr || r >= ring_end_[0] ? &note_of(rings_[r]) : nullptr);
  triangles_.clear();
  positions_.clear();
  for (const Index v : numbered_) number_[at(v)] = -1;
  numbered_.clear();
  number_.resize(m_.positions.size(), -1);
  for (const FreshTriangle& f : core) take(f);
  for (const Index t : rings_) take(there(t));
  PatchNotes notes{patch_notes_, numbered_, number_};
  return plate_energy(triangles_, core.size() + ring_end_[0], positions_, &notes);
}

double BendingCost::change(const std::vector<FreshTriangle>& fresh, const std::vector<Index>& old) {
  gather(old, 2);
  const double less = hinges_of(old), more = hinges_of(fresh);
  if (laws_.kind == Bending::hinge || is_slight(less + more + 2 * hinges_beyond()))
    return more - less;
  std::vector<FreshTriangle> before;
  for (const Index t : old) before.push_back(there(t));
  gather(old, 3);
  return plates_of(fresh, nullptr) - plates_of(before, &old);
}

double BendingCost::around(const std::vector<Index>& triangles) {
  gather(triangles, 3);
  if (laws_.kind == Bending::hinge) return hinges_of(triangles);
  std::vector<FreshTriangle> core;
  for (const Index t : triangles) core.push_back(there(t));
  return plates_of(core, &triangles);
}

double BendingCost::hinges_at(const std::vector<Index>& triangles) {
  gather(triangles, 2);
  return hinges_of(triangles) + hinges_beyond();
}

}  // namespace weft
