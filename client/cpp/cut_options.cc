#include "client/cpp/cut_options.h"

namespace kerf::client {

v1::View picture_view(const v1::Camera& camera, double width_px, double height_px, v1::View::Layers layers) {
  v1::View view;
  *view.mutable_camera() = camera;
  view.set_width_px(width_px);
  view.set_height_px(height_px);
  view.set_layers(layers);
  return view;
}

}  // namespace kerf::client
