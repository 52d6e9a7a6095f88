#include "weft/kernels/assemble/active_set_update.hpp"

#include "tests/parity/assemble/contact_set.hpp"

namespace weft::parity {
namespace {

/// Every launch takes all contacts, so `parts` is how often the same is done to a fresh copy.
template <class T, bool last, bool early = false, bool compare = false, bool parted = false>
struct ActiveSetUpdateCase {
  using Scalar = T;
  ContactSet<T> set{20, 2500};
  T h = T(0.0078125);
  double inverse_gravity = 0.125;
  std::vector<double> inverse_mass{0.5, 2, 1};

  std::vector<Index> components() const {
    std::vector<Index> result;
    for (Index v = 0; v < set.cloth; ++v) result.push_back(v * 3 / set.cloth);
    return result;
  }

  Outputs compute(Device& device, Index parts) const {
    Outputs result;
    const auto x = upload(device, set.positions), x0 = upload(device, set.positions_t0);
    const auto component = upload(device, components());
    const auto inverse = upload(device, inverse_mass);
    const auto touched = upload(device, levels(set.cloth));
    for (Index part = 0; part < parts; ++part) {
      const auto contacts_d = upload(device, set.contacts);
      const Buffer<double> mismatch(device, 1);
      const auto force =
          upload(device, std::vector<std::int64_t>(component_sums * inverse_mass.size()));
      launch(device.compute(), AssembleActiveSetUpdate<T>{
                                   contacts_d.span(), x.span(), x0.span(), component.span(),
                                   inverse.span(), set.cloth, h, inverse_gravity, touched.span(),
                                   last, early, compare, parted, mismatch.span(), force.span()});
      std::vector<double> weights;
      for (const std::int64_t sum : download(force))
        weights.push_back(static_cast<double>(sum) / weight_one);
      result = numbers(download(contacts_d), download(mismatch), weights);
    }
    return result;
  }
  template <class U>
  static Outputs numbers(const std::vector<Contact<U>>& all, const std::vector<double>& mismatch,
                         const std::vector<double>& force) {
    std::vector<double> push, drag, limit, stiffness, thickness;
    std::vector<Vec3<U>> slide;
    for (const Contact<U>& c : all) {
      push.push_back(double{c.push});
      drag.push_back(double{c.drag});
      stiffness.push_back(double{c.stiffness});
      thickness.push_back(double{c.thickness});
      limit.push_back(double{c.drag_limit});
      slide.push_back(c.slide);
    }
    Outputs result = {{"mismatch", mismatch},
                      {"push", push},
                      {"drag", drag},
                      {"stiffness", stiffness},
                      {"thickness", thickness}};
    if (early)
      EXPECT_EQ(force, std::vector<double>(force.size())) << "forces are not looked at";
    else
      result.push_back({"force", force});
    if (!last) {
      result.push_back({"limit", limit});
      result.push_back(output("slide", slide));
    }
    return result;
  }

  /// @return what a contact that is crushed in a jam pushes once it is firm, less what it was taken
  /// for
  double make_firm(Contact<double>& c, const std::vector<Vec3<double>>& x,
                   const std::vector<Vec3<double>>& x0) const {
    double gap = 0, gap_t0 = 0;
    for (int j = 0; j < 4; ++j) {
      gap += c.w[j] * dot(c.n, x[static_cast<std::size_t>(c.v[j])]);
      gap_t0 += c.w[j] * dot(c.n, x0[static_cast<std::size_t>(c.v[j])]);
    }
    if (last || early || !plainly_crushed(c, gap, gap_t0) || !has_level(c, levels(set.cloth)))
      return 0;
    const double room = gap_t0 - 0.8 * c.reach;
    const double factor = room > (gap_t0 - gap) / 24 ? (gap_t0 - gap) / room : 24;
    const double taken = c.push * (c.thickness - gap);
    const double force_t0 = c.stiffness * (c.thickness - gap_t0);
    c.stiffness *= factor;
    if (force_t0 > 0) c.thickness = gap_t0 + force_t0 / c.stiffness;
    c.push = c.stiffness;
    return std::max(0.0, c.stiffness * (c.thickness - gap)) - taken;
  }

  /// Corner by corner.
  Outputs reference() const {
    const std::vector<Vec3<double>> x = in_double(set.positions), x0 = in_double(set.positions_t0);
    std::vector<Contact<double>> all;
    double sum = 0;
    std::vector<double> force(component_sums * inverse_mass.size());
    const std::vector<Index> component = components();
    bool any_met = false, any_apart = false;
    for (const Contact<T>& contact : set.contacts) {
      Contact<double> c = in_double(contact);
      const ContactMotion<double> m =
          contact_motion(c, Span<const Vec3<double>>(x), Span<const Vec3<double>>(x0));
      const bool met = !(m.gap > 0);
      (met ? any_met : any_apart) = true;
      if (parted && met) {
        all.push_back(c);
        continue;
      }
      const double firmer = make_firm(c, x, x0);
      const FrictionTangent<double> taken{c.drag, c.drag_limit, c.slide};
      ContactWeights<double> right = contact_weights(c, m);
      if (early) right.drag = taken;
      const Vec3<double> more =
          friction_force(right.drag, m.displacement) - friction_force(taken, m.displacement);
      const double across = length(more);
      const bool pulls = !early && c.push > 0 && !(right.push > 0);
      // As it acts on the second primitive.
      const double depth = c.thickness - m.gap;
      const Vec3<double> pull = pulls ? (c.push * depth) * c.n : Vec3<double>{};
      for (int side = 0; side < 2; ++side) {
        const Index v = c.v[3 * side];
        if (v >= set.cloth) continue;
        const auto own = static_cast<std::size_t>(component[static_cast<std::size_t>(v)]);
        const Index other = c.v[3 - 3 * side];
        if (other < set.cloth &&
            component[static_cast<std::size_t>(other)] == component[static_cast<std::size_t>(v)])
          continue;
        const double per_force = inverse_gravity * inverse_mass[own];
        double* sums = &force[component_sums * own];
        const auto add = [&sums, per_force](double newtons) {
          *sums++ += std::rint(newtons * per_force * weight_one) / weight_one;
        };
        for (const Vec3<double>& on_second : {more, pull})
          for (int k = 0; k < 3; ++k) add((side == 0 ? -1 : 1) * on_second[k]);
        add(early ? 0 : right.push * depth);
      }
      const double normal = firmer + (right.push - c.push) * (c.thickness - m.gap);
      for (int j = 0; j < 4; ++j)
        if (c.v[j] < set.cloth) sum += c.w[j] * c.w[j] * (normal * normal + across * across);
      c.push = right.push;
      const bool turned = last && dot(c.slide, right.drag.slide) < 0;
      c.drag = turned ? c.hold : right.drag.stiffness;
      c.drag_limit = right.drag.limit;
      c.slide = right.drag.slide;
      all.push_back(compare ? in_double(contact) : c);
    }
    EXPECT_TRUE(any_met && any_apart);
    return numbers(all, {sum * double{h} * double{h}}, force);
  }
};

using Cases = testing::Types<
    ActiveSetUpdateCase<float, true>, ActiveSetUpdateCase<float, false>,
    ActiveSetUpdateCase<double, true>, ActiveSetUpdateCase<double, false>,
    ActiveSetUpdateCase<float, false, true>, ActiveSetUpdateCase<double, false, true>,
    ActiveSetUpdateCase<float, false, true, true>, ActiveSetUpdateCase<double, false, true, true>,
    ActiveSetUpdateCase<float, false, false, true>, ActiveSetUpdateCase<double, false, false, true>,
    ActiveSetUpdateCase<float, false, false, false, true>,
    ActiveSetUpdateCase<double, false, false, false, true>>;
INSTANTIATE_TYPED_TEST_SUITE_P(AssembleActiveSetUpdate, KernelParity, Cases);

}  // namespace
}  // namespace weft::parity
