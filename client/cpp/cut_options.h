#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "client/cpp/geometry.h"
#include "kerf/v1/scene.pb.h"

namespace kerf::client {

// A box in material coordinates, m.
struct Box {
  Point low;
  Point high;
};

// What may be said of a cut beside its curve; 0 and absent stand for the defaults. Field by field in
// proto/kerf/v1/scene.proto.
struct CutOptions {
  double tolerance = 0.0;              // curve to lips at most, as a share of the edge length there, 1e-6..0.5
  double tolerance_m = 0.0;            // the same in metres, instead
  double min_angle_deg = 0.0;          // asked of new triangles, 5..28
  std::int32_t max_new_triangles = 0;  // 1..1000000
  v1::Cut::Method method = v1::Cut::METHOD_UNSPECIFIED;
  v1::Cut::Quality quality = v1::Cut::QUALITY_UNSPECIFIED;
  double tip_edge_length_m = 0.0;     // at the tips inside the sheet
  double tip_grading = 0.0;           // growth of edges away from them, 1.05..10
  bool relax = true;                  // old vertices may move in material space
  double width_m = 0.0;               // of the strip that is taken away around the curve
  bool fit_sheet = false;             // scaled and moved into the sheet less its margin
  std::optional<Box> fit = {};        // or into this box
  std::vector<double> dash = {};      // m cut and m left, in turn
  double dash_offset = 0.0;           // m into the pattern at which it begins
  std::optional<v1::View> view = {};  // the curve is in pixels of this picture
};

// A cut to be made later, one of Sheet::cut_all().
v1::Cut make_cut(v1::Curve curve, const CutOptions& options = {});

// The picture that a cut is drawn on: as Sheet::render() draws it with the same camera and size. Pixel (0, 0) is its
// top left corner.
v1::View picture_view(const v1::Camera& camera, double width_px, double height_px,
                      v1::View::Layers layers = v1::View::NEAREST);

}  // namespace kerf::client
