#include "host/implicit/contact/self_separation.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <functional>

#include "host/exec/host_device.hpp"

namespace weft {
namespace {

/// After each failure in a row of certificates twice as many motions go by without one, up to this.
constexpr int without_max = 256;

/// Null if nothing could be proved: not on the host, not asked for, or no cloth of that kind.
template <class T>
std::unique_ptr<SelfCertificate<T>> make_certificate(const Store<T>& store) {
  const ContactSettings& contact = store.scene().contact;
  if (!contact.self || !contact.self_certificate) return nullptr;
  for (int r = 0; r < store.devices().size(); ++r)
    if (store.devices()[r].backend() != Backend::host) return nullptr;
  const Model& m = store.model();
  const std::vector<Tri> cloth(m.triangles.begin(), m.triangles.begin() + m.cloth_triangle_count);
  auto certificate = std::make_unique<SelfCertificate<T>>(
      planar_domains(m.cloth_vertex_count, cloth, m.material_points), contact_thickness(contact),
      store.devices().size());
  return certificate->of_use() ? std::move(certificate) : nullptr;
}

}  // namespace

template <class T>
bool SelfSeparation<T>::holds() {
  // Only once it is asked for: other methods make searches that never take place.
  if (!certificate_) certificate_ = make_certificate(store_);
  if (!*certificate_) return false;
  if (stays_apart_) return *stays_apart_;
  if (without_ > 0) {
    --without_;
    stays_apart_ = false;
    return false;
  }
  stays_apart_ = prove([this](const auto& motion, const auto& for_all) {
    return (*certificate_)->holds(motion, for_all);
  });
  failures_ = *stays_apart_ ? 0 : std::min(failures_ + 1, 30);
  if (failures_ > 0) without_ = std::min(1 << failures_, without_max) - 1;
  return *stays_apart_;
}

template <class T>
bool SelfSeparation<T>::holds_to_end() {
  return prove([this](const auto& motion, const auto& for_all) {
    return (*certificate_)->holds_to(motion, for_all);
  });
}

/// Asks prove(motion, for_all) of the motion to where positions_t1 are now.
template <class T>
template <class Prove>
bool SelfSeparation<T>::prove(Prove prove) {
  const auto begin = std::chrono::steady_clock::now();
  const bool proved = prove(
      [this](int r) {
        const auto n = static_cast<std::size_t>(r);
        return typename SelfCertificate<T>::Motion{store_.rank(r).positions.span(),
                                                   motion_[n].positions_t1.span()};
      },
      [this](const std::function<void(int)>& part) {
        DeviceSet& devices = store_.devices();
        for (int r = 0; r < devices.size(); ++r)
          submit_host(devices[r].compute(), [&part, r] { part(r); });
        // All of them, whatever happens: they refer to what is of this call.
        std::exception_ptr error;
        for (int r = 0; r < devices.size(); ++r) try {
            devices[r].compute().sync();
          } catch (...) {
            if (!error) error = std::current_exception();
          }
        if (error) std::rethrow_exception(error);
      });
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return proved;
}

template class SelfSeparation<float>;
template class SelfSeparation<double>;

}  // namespace weft
