#include "client/cpp/cut_options.h"

#include <utility>

namespace kerf::client {

v1::Cut make_cut(v1::Curve curve, const CutOptions& options) {
  v1::Cut cut;
  *cut.mutable_curve() = std::move(curve);
  cut.set_tolerance(options.tolerance);
  cut.set_tolerance_m(options.tolerance_m);
  cut.set_min_angle_deg(options.min_angle_deg);
  cut.set_max_new_triangles(options.max_new_triangles);
  cut.set_method(options.method);
  cut.set_quality(options.quality);
  cut.set_tip_edge_length_m(options.tip_edge_length_m);
  cut.set_tip_grading(options.tip_grading);
  if (!options.relax) cut.set_relax(false);
  cut.set_width_m(options.width_m);
  if (options.fit_sheet) cut.mutable_fit();
  if (options.fit) {
    *cut.mutable_fit()->mutable_min() = vec2(options.fit->low);
    *cut.mutable_fit()->mutable_max() = vec2(options.fit->high);
  }
  cut.mutable_dash()->Assign(options.dash.begin(), options.dash.end());
  cut.set_dash_offset(options.dash_offset);
  if (options.view) *cut.mutable_view() = *options.view;
  return cut;
}

v1::View picture_view(const v1::Camera& camera, double width_px, double height_px, v1::View::Layers layers) {
  v1::View view;
  *view.mutable_camera() = camera;
  view.set_width_px(width_px);
  view.set_height_px(height_px);
  view.set_layers(layers);
  return view;
}

}  // namespace kerf::client
