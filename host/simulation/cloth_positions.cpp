#include "host/simulation/cloth_positions.hpp"

#include "weft/core/at.hpp"
#include "weft/exec/launch.hpp"
#include "weft/kernels/integrate/world_positions.hpp"

namespace weft {

template <class T>
void ClothPositions<T>::gather(std::size_t cloth, const Vec3<double>& origin,
                               Span<Vec3<float>> to) {
  Device& device = store_.devices()[0];
  const Model& model = store_.model();
  if (vertices_.size() == 0) {
    const MemoryName name("state");
    vertices_ = Buffer<Index>(device);
    upload(device.compute(), vertices_, model.to_internal);
  }
  launch(device.compute(), IntegrateWorldPositions<T>{
                               vertices_.span().subspan(at(model.input_offset[cloth]), to.size()),
                               store_.rank(0).positions.span(), origin, to});
}

template <class T>
Span<Vec3<float>> ClothPositions<T>::buffer_of(std::size_t cloth) {
  const Model& model = store_.model();
  if (buffer_.size() == 0) {
    const MemoryName name("state");
    buffer_ = Buffer<Vec3<float>>(store_.devices()[0], model.to_internal.size());
  }
  const std::size_t first = at(model.input_offset[cloth]);
  return buffer_.span().subspan(first, at(model.input_offset[cloth + 1]) - first);
}

template <class T>
void ClothPositions<T>::download(std::size_t cloth, const Vec3<double>& origin,
                                 std::vector<Vec3<float>>& to) {
  Queue& queue = store_.devices()[0].compute();
  const Model& model = store_.model();
  to.resize(at(model.input_offset[cloth + 1] - model.input_offset[cloth]));
  if (queue.backend() == Backend::host) {
    gather(cloth, origin, to);
  } else {
    const Span<Vec3<float>> from = buffer_of(cloth);
    gather(cloth, origin, from);
    queue.copy(to.data(), from.data(), from.size() * sizeof(Vec3<float>));
  }
  queue.sync();
}

template <class T>
DevicePositions ClothPositions<T>::on_device(std::size_t cloth, const Vec3<double>& origin,
                                             void* stream) {
  Device& device = store_.devices()[0];
  Queue& queue = device.compute();
  const Span<Vec3<float>> to = buffer_of(cloth);
  queue.wait_for_stream(stream);
  gather(cloth, origin, to);
  queue.let_stream_wait(stream);
  return {to.data(), to.size(), device.gpu()};
}

template class ClothPositions<float>;
template class ClothPositions<double>;

}  // namespace weft
