#pragma once

#include <string>

#include "kerf/v1/files.pb.h"
#include "kerf/v1/geometry.pb.h"
#include "server/base/result.h"
#include "server/service/drawing/placing.h"
#include "server/service/wire/geometry_codec.h"

// Converts kerf.v1.Svg, kerf.v1.Dxf and what chooses parts of a drawing.
namespace kerf::wire {

// Errors: those of drawing::validate().
Result<drawing::Reading> decode_reading(const v1::DrawingReading& message, const std::string& path);

// Reads the drawing, without choosing parts of it. Errors: those of svg::read() and read_content(), the latter with
// kind SVG; SVG_TWICE if there are text and data.
Result<drawing::Drawing> read_drawing(const v1::Svg& message, const drawing::Reading& reading, const std::string& path,
                                      const FileReader& read_file);

// Errors: those of dxf::read() and read_content(), the latter with kind DXF.
Result<drawing::Drawing> read_drawing(const v1::Dxf& message, const drawing::Reading& reading, const std::string& path,
                                      const FileReader& read_file);

// Reads the drawing and chooses what is cut. `dashes`: dashed strokes become dashes.
Result<DecodedCurve> decode_drawing(const v1::Svg& message, const std::string& path, const FileReader& read_file,
                                    bool dashes);
Result<DecodedCurve> decode_drawing(const v1::Dxf& message, const std::string& path, const FileReader& read_file);

// Describes a drawing. Fields of errors begin with "svg" or "dxf". Errors: those of reading the drawing, and of its
// selectors; CHOICE_MISSING. A drawing of which nothing can be cut is none.
Result<v1::DrawingReport> inspect_drawing(const v1::InspectDrawingRequest& request);

}  // namespace kerf::wire
