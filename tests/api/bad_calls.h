#pragma once

#include <string>
#include <vector>

#include "server/base/result.h"

namespace kerf::api {

// A call that must be refused on a server with the sheets a and b of 7 x 7 vertices and no renderer.
struct BadCall {
  const char* method;  // "SheetService/GetSheet"
  std::string json;
  ErrorCode code;
  const char* field;  // null: not looked at
};

inline std::string cut_json(const std::string& curve) {
  return R"({"parent":"sheets/a","cut":{"curve":{)" + curve + "}}}";
}

inline std::vector<BadCall> bad_cuts() {
  const ErrorCode invalid = ErrorCode::kInvalidArgument;
  const char* create = "CutService/CreateCut";
  std::string many = R"("polyline":{"points":[)";
  for (int i = 0; i <= 4096; ++i) many += (i == 0 ? "" : ",") + (R"({"x":)" + std::to_string(i) + "}");
  many += "]}";
  return {
      {create, cut_json(R"("circle":{"center":{"x":"NaN"},"radius_m":0.1})"), invalid, "cut.curve.circle.center.x"},
      {create, cut_json(R"("circle":{"center":{"y":"Infinity"},"radius_m":0.1})"), invalid,
       "cut.curve.circle.center.y"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"view":{"nearest_m":"NaN"}}})",
       invalid, "cut.view.nearest_m"},
      {"CutService/CreateCuts",
       R"({"parent":"sheets/a","cuts":[{"curve":{"circle":{"radius_m":0.1}},"view":{"farthest_m":"-Infinity"}}]})",
       invalid, "cuts[0].view.farthest_m"},
      {create, cut_json(R"("circle":{"radius_m":-1})"), invalid, "cut.curve.circle.radius_m"},
      {create, cut_json(R"("polyline":{"points":[{"x":1e300},{}]})"), invalid, "cut.curve.polyline.points[0].x"},
      {create, cut_json(R"("polyline":{"points":[{"x":0.5},{"x":0.5}]})"), invalid, "cut.curve.polyline.points"},
      {create, cut_json(R"("polyline":{"points":[{"x":0.5}]})"), invalid, "cut.curve.polyline.points"},
      {create, cut_json(many), invalid, "cut.curve.polyline.points"},
      {create, cut_json(R"("bezier":{"points":[{"x":1},{"x":2},{"x":3}]})"), invalid, "cut.curve.bezier.points"},
      {create, cut_json(""), invalid, "cut.curve"},
      {create, R"({"parent":"sheets/a"})", invalid, "cut"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"tolerance":0.6}})", invalid,
       "cut.tolerance"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"tolerance_m":1e-10}})", invalid,
       "cut.tolerance_m"},
      {create,
       R"({"parent":"sheets/a","cut":{"curve":{"bezier":{"points":[{},{"x":0.2},{"x":0.4,"y":0.5},{"y":0.3}]}},"tolerance_m":1e-9}})",
       invalid, "cut.curve"},
      {create,
       R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"method":"ELEMENT","tip_edge_length_m":0.01}})",
       invalid, "cut.tip_edge_length_m"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"width_m":-0.01}})", invalid,
       "cut.width_m"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"width_m":1e5}})", invalid,
       "cut.width_m"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"width_m":100}})",
       ErrorCode::kFailedPrecondition, "cut.width_m"},
      {create,
       R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"quality":"FINE","min_angle_deg":22}})",
       invalid, "cut.quality"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}},"max_new_triangles":2000000}})",
       invalid, "cut.max_new_triangles"},
      {create, R"({"parent":"a","cut":{"curve":{"circle":{"radius_m":0.1}}}})", invalid, "parent"},
      {create, R"({"parent":"sheets/nobody","cut":{"curve":{"circle":{"radius_m":0.1}}}})", ErrorCode::kNotFound,
       "parent"},
      {create,
       R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}}},"request_id":")" + std::string(65, 'r') +
           "\"}",
       invalid, "request_id"},
      {create, R"({"parent":"sheets/a","cut":{"curve":{"circle":{"radius_m":0.1}}},"at_tick":-1})", invalid, "at_tick"},
      {create, R"({"parent":"sheets/nobody","cut":{"curve":{"circle":{"radius_m":0.1}}},"at_tick":9})",
       ErrorCode::kNotFound, "parent"},
      {"CutService/CreateCuts", R"({"parent":"sheets/a"})", invalid, "cuts"},
      {"CutService/CreateCuts", R"({"parent":"sheets/a","cuts":[{"curve":{"circle":{"radius_m":0.1}}},{}]})", invalid,
       "cuts[1].curve"},
      {"CutService/CreateCuts",
       R"({"parent":"sheets/a","cuts":[{"curve":{"circle":{"radius_m":0.1}}},{"curve":{"circle":{"radius_m":-1}}}]})",
       invalid, "cuts[1].curve.circle.radius_m"},
      {"CutService/CancelScheduledCuts", R"({"name":"sheets/a/cuts/1"})", invalid, "name"},
      {"CutService/CancelScheduledCuts", R"({"name":"sheets/nobody/scheduledCuts/1"})", ErrorCode::kNotFound, "name"},
      {"CutService/CreateCuts", R"({"parent":"sheets/a","cuts":[{"curve":{"circle":{"radius_m":0.1}}}],"at_tick":-1})",
       invalid, "at_tick"},
      {"CutService/UndoCut", R"({"parent":"sheets/nobody"})", ErrorCode::kNotFound, "parent"},
      {"CutService/UndoCut", R"({"parent":"sheets/a"})", ErrorCode::kFailedPrecondition, nullptr},
      {"CutService/RedoCut", R"({"parent":"sheets/a"})", ErrorCode::kFailedPrecondition, nullptr},
      {"CutService/RedoCut", R"({"parent":"a"})", invalid, "parent"},
      {"CutService/ListPieces", R"({"parent":"sheets/nobody"})", ErrorCode::kNotFound, "parent"},
      {"CutService/ListPieces", R"({"parent":"sheets/a","page_size":-1})", invalid, "page_size"},
      {"CutService/ListPieces", R"({"parent":"sheets/a","page_token":"0"})", invalid, "page_token"},
      {"CutService/ListCuts", R"({"parent":"sheets/nobody"})", ErrorCode::kNotFound, "parent"},
      {"CutService/ListCuts", R"({"parent":"sheets/a","page_size":1001})", invalid, "page_size"},
      {"CutService/ListCuts", R"({"parent":"sheets/a","page_token":"x"})", invalid, "page_token"},
  };
}

inline std::vector<BadCall> bad_sheet_calls() {
  const ErrorCode invalid = ErrorCode::kInvalidArgument;
  const ErrorCode not_found = ErrorCode::kNotFound;
  const std::string grid = R"("scene":{"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}})";
  const char* create = "SheetService/CreateSheet";
  const char* get = "SheetService/GetSheet";
  return {
      {create, R"({"sheet_id":"c"})", invalid, "scene"},
      {create, R"({"sheet_id":"c","scene":{}})", invalid, "scene.mesh"},
      {create, R"({"sheet_id":"C",)" + grid + "}", invalid, "sheet_id"},
      {create, R"({"sheet_id":"a",)" + grid + "}", ErrorCode::kAlreadyExists, nullptr},
      {create, R"({"scene":{"grid":{"columns":1000,"rows":1000,"width_m":1,"height_m":1}}})", invalid,
       "scene.grid.rows"},
      {create, R"({"scene":{"grid":{"columns":3,"rows":3,"width_m":"NaN","height_m":1}}})", invalid,
       "scene.grid.width_m"},
      {create, R"({"scene":{"obj":{"file":"/etc/passwd"}}})", invalid, "scene.obj.file"},
      {create, R"({"scene":{"ply":{"file":"/etc/passwd"}}})", invalid, "scene.ply.file"},
      {create, R"({"scene":{"ply":{"data":"cGx5Cg=="}}})", invalid, "scene.ply.data"},
      {create, R"({"scene":{"inline":{"material_positions":[0,0,1,0,0,1],"triangles":[0,1,3]}}})", invalid,
       "scene.inline.triangles"},
      {create, R"({"scene":{"inline":{"material_positions":[0,0,1,0,2,0],"triangles":[0,1,2]}}})", invalid,
       "scene.inline.triangles"},
      {create, R"({"scene":{"gravity_mps2":{"z":-1e5},"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}}})",
       invalid, "scene.gravity_mps2.z"},
      {create, R"({"scene":{"tick_rate_hz":1e9,"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}}})", invalid,
       "scene.tick_rate_hz"},
      {create,
       R"({"scene":{"pins":[{"vertices":{"vertices":[99]}}],)"
       R"("grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}}})",
       invalid, "scene.pins[0].vertices.vertices[0]"},
      {create, "{\"scene\":{\"grid\":{\"colums\":3}}}", invalid, "scene.grid.colums"},
      {create, "not json", invalid, ""},
      {get, R"({"name":"sheets/nobody"})", not_found, "name"},
      {get, R"({"name":"sheets/"})", invalid, "name"},
      {get, R"({"name":"sheets/a/cuts/1"})", invalid, "name"},
      {get, R"({"name":"sheets/../a"})", invalid, "name"},
      {get, "{}", invalid, "name"},
      {"SheetService/DeleteSheet", R"({"name":"sheets/nobody"})", not_found, "name"},
      {"SheetService/PauseSheet", R"({"name":"sheets/nobody"})", not_found, "name"},
      {"SheetService/ResumeSheet", R"({"name":"sheets/nobody"})", not_found, "name"},
      {"SheetService/ResetSheet", R"({"name":"sheets/nobody"})", not_found, "name"},
      {"SheetService/GetSheetState", R"({"name":"sheets/nobody"})", not_found, "name"},
      {"SheetService/ExportSheet", R"({"name":"sheets/nobody"})", not_found, "name"},
      {"SheetService/AnalyzeSheet", R"({"name":"sheets/a"})", invalid, "analysis.kind"},
      {"SheetService/ExportSheet", R"({"name":"sheets/a","format":7})", invalid, "format"},
      {"SheetService/StepSheet", R"({"name":"sheets/a","ticks":0})", invalid, "ticks"},
      {"SheetService/StepSheet", R"({"name":"sheets/a","ticks":100001})", invalid, "ticks"},
      {"SheetService/SetSheetSpeed", R"({"name":"sheets/nobody","speed":1})", not_found, "name"},
      {"SheetService/SetSheetSpeed", R"({"name":"sheets/a"})", invalid, "speed"},
      {"SheetService/SetSheetSpeed", R"({"name":"sheets/a","speed":0.0099})", invalid, "speed"},
      {"SheetService/SetSheetSpeed", R"({"name":"sheets/a","speed":4.01})", invalid, "speed"},
      {"SheetService/SetSheetSpeed", R"({"name":"sheets/a","speed":"NaN"})", invalid, "speed"},
      {"SheetService/SaveState", R"({"parent":"sheets/nobody","state_id":"one"})", not_found, "parent"},
      {"SheetService/SaveState", R"({"parent":"sheets/a"})", invalid, "state_id"},
      {"SheetService/SaveState", R"({"parent":"sheets/a","state_id":"../a"})", invalid, "state_id"},
      {"SheetService/RestoreState", R"({"name":"sheets/nobody/states/one"})", not_found, "name"},
      {"SheetService/RestoreState", R"({"name":"sheets/a/states/one"})", not_found, "name"},
      {"SheetService/RestoreState", R"({"name":"sheets/a"})", invalid, "name"},
      {"SheetService/RestoreState", R"({"name":"sheets/a/states/"})", invalid, "name"},
      {"SheetService/ListStates", R"({"parent":"sheets/nobody"})", not_found, "parent"},
      {"SheetService/DeleteState", R"({"name":"sheets/a/states/one"})", not_found, "name"},
      {"SheetService/DeleteState", R"({"name":"sheets/a/states/One"})", invalid, "name"},
      {"SheetService/ListSheets", R"({"page_size":-1})", invalid, "page_size"},
      {"SheetService/ListSheets", R"({"page_token":"../a"})", invalid, "page_token"},
  };
}

inline std::vector<BadCall> bad_touches() {
  const ErrorCode invalid = ErrorCode::kInvalidArgument;
  const char* grab = "InteractionService/GrabPoint";
  const char* image = "RenderService/RenderImage";
  const char* material = "InteractionService/SetSheetMaterial";
  const char* folds = "InteractionService/SetSheetSelfContact";
  return {
      {grab, R"({"name":"sheets/nobody","grab":{"grab_id":"g","vertex":0}})", ErrorCode::kNotFound, "name"},
      {grab, R"({"name":"sheets/a"})", invalid, "grab"},
      {grab, R"({"name":"sheets/a","grab":{"grab_id":"g"}})", invalid, "grab.point"},
      {grab, R"({"name":"sheets/a","grab":{"grab_id":"g","vertex":49}})", invalid, "grab.vertex"},
      {grab, R"({"name":"sheets/a","grab":{"grab_id":"g","material":{"x":7}}})", invalid, "grab.material"},
      {grab, R"({"name":"sheets/a","grab":{"grab_id":"g","vertex":0,"target":{"x":"NaN"}}})", invalid, "grab.target.x"},
      {"InteractionService/DragPoint", R"({"name":"sheets/a","drag":{"grab_id":"none","target":{}}})",
       ErrorCode::kNotFound, "drag.grab_id"},
      {"InteractionService/ReleasePoint", R"({"name":"sheets/a","release":{"grab_id":"none"}})", ErrorCode::kNotFound,
       "release.grab_id"},
      {"InteractionService/SetSheetPins", R"({"name":"sheets/a","set_pins":{"pins":[{"vertices":{"vertices":[-1]}}]}})",
       invalid, "set_pins.pins[0].vertices.vertices[0]"},
      {"InteractionService/SetSheetGravity", R"({"name":"sheets/a","set_gravity":{"gravity_mps2":{"x":"NaN"}}})",
       invalid, "set_gravity.gravity_mps2.x"},
      {"InteractionService/SetSheetWind", R"({"name":"sheets/a","set_wind":{"wind":{"velocity_mps":{"x":1001}}}})",
       invalid, "set_wind.wind.velocity_mps.x"},
      {material, R"({"name":"sheets/nobody","set_material":{"material":{}}})", ErrorCode::kNotFound, "name"},
      {material, R"({"name":"sheets/a"})", invalid, "set_material"},
      {material, R"({"name":"sheets/a","set_material":{}})", invalid, "set_material.material"},
      {material, R"({"name":"sheets/a","set_material":{"material":{"preset":"wood"}}})", invalid,
       "set_material.material.preset"},
      {material, R"({"name":"sheets/a","set_material":{"material":{"thickness_m":-1}}})", invalid,
       "set_material.material.thickness_m"},
      {material, R"({"name":"sheets/a","set_material":{"material":{},"part":0}})", invalid, "set_material.part"},
      {folds, R"({"name":"sheets/nobody","set_self_contact":{"mode":"ON"}})", ErrorCode::kNotFound, "name"},
      {folds, R"({"name":"sheets/a"})", invalid, "set_self_contact"},
      {folds, R"({"name":"sheets/a","set_self_contact":{"mode":3}})", invalid, "set_self_contact.mode"},
      {folds, R"({"name":"sheets/a","set_self_contact":{"friction":10.5}})", invalid, "set_self_contact.friction"},
      {folds, R"({"name":"sheets/a","set_self_contact":{"thickness_m":0}})", invalid, "set_self_contact.thickness_m"},
      {folds, R"({"name":"sheets/a","set_self_contact":{"thickness_m":0.01,"material_thickness":true}})", invalid,
       "set_self_contact.material_thickness"},
      {image, R"({"name":"sheets/a","width_px":15})", invalid, "width_px"},
      {image, R"({"name":"sheets/a","height_px":4097})", invalid, "height_px"},
      {image, R"({"name":"sheets/a","jpeg_quality":101})", invalid, "jpeg_quality"},
      {image, R"({"name":"sheets/a","format":9})", invalid, "format"},
      {image, R"({"name":"sheets/a","camera":{"eye":{"x":1},"target":{"x":1}}})", invalid, "camera.target"},
      {image, R"({"name":"sheets/a","camera":{"eye":{"z":1},"target":{}}})", invalid, "camera.up"},
      {image, R"({"name":"sheets/a","camera":{"eye":{"x":"NaN"},"target":{}}})", invalid, "camera.eye.x"},
      {image, R"({"name":"sheets/a","camera":{"eye":{"x":1},"target":{},"vertical_fov_deg":180}})", invalid,
       "camera.vertical_fov_deg"},
      {image, R"({"name":"sheets/a"})", ErrorCode::kUnavailable, ""},  // there is no renderer here
  };
}

}  // namespace kerf::api
