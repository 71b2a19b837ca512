#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cpp/geometry.h"
#include "kerf/v1/scene.pb.h"

namespace kerf::client {

// Represents a box in material coordinates, m.
struct Box {
  Point low;
  Point high;
};

// Holds the options of a cut besides its curve; 0 and absent mean the defaults. proto/kerf/v1/scene.proto describes
// each field. make_cut() copies each of them.
struct CutOptions {
  double tolerance = 0.0;  // Largest distance of the curve to the lips, as a share of the edge length there, 1e-6..0.5.
  double tolerance_m = 0.0;            // Replaces `tolerance`, m.
  double min_angle_deg = 0.0;          // Smallest angle wanted in new triangles, 5..28.
  std::int32_t max_new_triangles = 0;  // 1..1000000
  v1::Cut::Method method = v1::Cut::METHOD_UNSPECIFIED;
  v1::Cut::Quality quality = v1::Cut::QUALITY_UNSPECIFIED;
  double tip_edge_length_m = 0.0;     // Edge length wanted at the tips: the cut's ends inside the sheet.
  double tip_grading = 0.0;           // Growth of edges with each ring of triangles around a tip, 1.05..10.
  bool relax = true;                  // Old vertices may move in material space.
  double width_m = 0.0;               // Width of the strip removed around the curve.
  bool fit_sheet = false;             // Scale and move the curve into the sheet without its margin.
  std::optional<Box> fit = {};        // Scale and move the curve into this box.
  std::vector<double> dash = {};      // Lengths cut and left in turn, m.
  double dash_offset = 0.0;           // Place in the pattern of `dash` where the curve begins, m.
  std::optional<v1::View> view = {};  // Picture of the sheet in whose pixels the curve is.
  double join_m = 0.0;                // Ends of lines closer than this to another line, a lip or the border are joined.
  std::string component = {};         // Name of the component in whose coordinates the curve is; it alone is cut.
};

// Returns a cut to be made later, as one of Sheet::cut_all().
inline v1::Cut make_cut(v1::Curve curve, const CutOptions& options = {}) {
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
  cut.set_component(options.component);
  cut.set_join_m(options.join_m);
  return cut;
}

// Returns the view of a cut in pixels of a picture, as drawn by Sheet::render() with the same camera and size. Pixel
// (0, 0) is its top left corner.
v1::View picture_view(const v1::Camera& camera, double width_px, double height_px,
                      v1::View::Layers layers = v1::View::NEAREST);

}  // namespace kerf::client
