#include "host/view/view_sizing.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "host/geometry/tensor.hpp"

namespace weft {

Mat2<double> pixel_bounded(const Mat2<double>& tensor, const Mat2<double>& screen,
                           double pixel_min) {
  if (!(pixel_min > 0)) return tensor;
  // L = [a 0; b c]
  const double a = std::sqrt(tensor(0, 0));
  const double b = tensor(1, 0) / a;
  const double c = std::sqrt(std::max(0.0, tensor(1, 1) - b * b));
  if (!(c > 0)) return tensor;
  const Mat2<double> l{{a, 0, b, c}};
  const Mat2<double> inverse{{1 / a, 0, -b / (a * c), 1 / c}};
  const Mat2<double> bound = (1 / (pixel_min * pixel_min)) * (transpose(screen) * screen);
  Eigen2 m = eigen(inverse * bound * transpose(inverse));
  for (double& value : m.value) value = std::clamp(value, 0.0, 1.0);
  return l * compose(m) * transpose(l);
}

Mat2<double> view_tensor(const ViewField& field, Index triangle, const Tri& corners,
                         const Vec2<double> material[3], const Mat2<double>& tensor,
                         const Remeshing& sizes) {
  std::optional<Mat2<double>> above;
  for (const ViewField::View& view : field.views) {
    const double factor = view.factors[static_cast<std::size_t>(triangle)];
    Mat2<double> asked = (factor * factor) * tensor;
    const ViewCamera& camera = view.instant.camera;
    Vec2<double> pixels[3];
    bool in_front = true;
    for (int j = 0; j < 3; ++j) {
      const Vec3<double> seen =
          camera.seen(view.places.cloth[static_cast<std::size_t>(corners.v[j])]);
      in_front = in_front && seen[2] > camera.near();
      if (in_front) pixels[j] = camera.pixel(seen);
    }
    if (in_front)
      asked = pixel_bounded(asked, screen_jacobian(pixels, material), field.settings.pixel_min);
    above = above ? tensor_above({*above, asked}) : asked;
  }
  if (!above) return tensor;
  return clamped(*above, 1 / (sizes.size_max * sizes.size_max),
                 1 / (sizes.size_min * sizes.size_min), sizes.aspect_min * sizes.aspect_min);
}

}  // namespace weft
