#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/drawing_options.h"
#include "client/cpp/client.h"
#include "client/cpp/cut_options.h"
#include "server/base/disk.h"
#include "server/base/overloaded.h"
#include "server/service/offline/files.h"

namespace kerf::cli {
namespace {

struct CutArguments {
  std::string id;
  std::optional<std::string> bezier;
  std::optional<std::string> polyline;
  std::optional<std::string> circle;
  std::optional<std::string> ellipse;
  std::optional<std::string> rational;
  std::optional<std::string> path;
  std::optional<std::string> svg;
  std::optional<std::string> drawing;  // A file.
  DrawingArguments reading;
  std::optional<std::string> join;
  std::optional<std::string> fit;
  std::optional<std::string> dash;
  std::optional<std::string> view;
  std::string picture = "640x360";
  std::string layers = "nearest";
  double fov_deg = 0.0;
  std::string batch;  // A file.
  std::int64_t at_tick = 0;
  bool is_dry_run = false;
  std::string method = "neighbourhood";
  std::string quality = "default";
  bool no_relax = false;
  client::CutOptions options;  // Options that need no parsing of their own.
};

// Stores the parsed value of an option in `target`, or returns its error.
template <typename T, typename Target>
std::optional<UsageError> take(const char* option, Parsed<T> parsed, Target& target) {
  if (const auto* wrong = std::get_if<UsageError>(&parsed))
    return UsageError{std::string(option) + ": " + wrong->message};
  target = std::move(std::get<T>(parsed));
  return std::nullopt;
}

std::optional<UsageError> set_points(const CutArguments& arguments, v1::Curve& curve) {
  const bool is_bezier = arguments.bezier.has_value();
  std::vector<v1::Vec2> points;
  if (auto wrong = take(is_bezier ? "--bezier" : "--polyline",
                        parse_points(is_bezier ? *arguments.bezier : *arguments.polyline), points)) {
    return wrong;
  }
  if (is_bezier && (points.size() < 4 || points.size() % 3 != 1)) {
    return UsageError{"--bezier: " + std::to_string(points.size()) +
                      " points: a cubic Bezier curve has 4, each further piece 3 more"};
  }
  if (!is_bezier && points.size() < 2) return UsageError{"--polyline: at least 2 points are needed"};
  auto* target = is_bezier ? curve.mutable_bezier()->mutable_points() : curve.mutable_polyline()->mutable_points();
  target->Assign(points.begin(), points.end());
  return std::nullopt;
}

// Sets the curve from the option given, except --svg; returns the error, if any.
std::optional<UsageError> set_curve(const CutArguments& arguments, v1::Curve& curve) {
  if (arguments.circle) return take("--circle", parse_circle(*arguments.circle), *curve.mutable_circle());
  if (arguments.ellipse) return take("--ellipse", parse_ellipse(*arguments.ellipse), *curve.mutable_ellipse());
  if (arguments.rational) return take("--rational", parse_rational(*arguments.rational), *curve.mutable_path());
  if (arguments.path) return take("--path", parse_path(*arguments.path), *curve.mutable_path());
  return set_points(arguments, curve);
}

std::optional<UsageError> take_reading(const DrawingArguments& arguments, v1::DrawingReading& reading) {
  Parsed<v1::DrawingReading> parsed = to_reading(arguments);
  if (const auto* wrong = std::get_if<UsageError>(&parsed)) return *wrong;
  reading = std::get<v1::DrawingReading>(std::move(parsed));
  return std::nullopt;
}

// Returns the larger side of the sheet in metres, up to a factor near 1; 0 if the server does not say.
double sheet_size(client::Client& client, const std::string& id, const std::string& component) {
  v1::GetSheetRequest request;
  request.set_name("sheets/" + id);
  v1::Sheet sheet;
  if (!client.call(&v1::SheetService::Stub::GetSheet, client.sheets(), request, sheet).ok()) return 0.0;
  for (const v1::SheetComponent& each : sheet.components()) {
    if (each.name() != component) continue;
    return std::max(each.extent().max().x() - each.extent().min().x(),
                    each.extent().max().y() - each.extent().min().y());
  }
  const v1::GridMesh& grid = sheet.scene().grid();
  if (grid.width_m() > 0.0) return std::max(grid.width_m(), grid.height_m());
  v1::ListPiecesRequest pieces;
  pieces.set_parent(request.name());
  pieces.set_page_size(1000);
  v1::ListPiecesResponse page;
  if (!client.call(&v1::CutService::Stub::ListPieces, client.cuts(), pieces, page).ok()) return 0.0;
  double area = 0.0;
  for (const v1::Piece& piece : page.pieces()) area += piece.area_m2();
  return std::sqrt(area);
}

// Returns a thousandth of the drawing's size on the sheet, within which ends of its lines are joined.
double default_join(client::Client& client, const std::string& id, const v1::Cut& cut) {
  constexpr double kShareOfDrawing = 1e-3;
  if (cut.has_view()) return 0.0;
  const Result<offline::DrawingSize> drawing = offline::size_of_drawing(cut.curve());
  if (!drawing.ok()) return 0.0;  // The server says why.
  double size = std::max(drawing->width, drawing->height);
  if (!drawing->is_placed) {
    const v1::MaterialBox& box = cut.fit();
    const double width = box.has_max() ? box.max().x() - box.min().x() : sheet_size(client, id, cut.component());
    const double height = box.has_max() ? box.max().y() - box.min().y() : width;
    size *= std::min(width / std::max(drawing->fitted_width, 1e-9), height / std::max(drawing->fitted_height, 1e-9));
  }
  const double join = kShareOfDrawing * size;
  return join >= 1e-9 && join <= 1e4 ? join : 0.0;
}

std::optional<UsageError> set_view(const CutArguments& arguments, v1::View& view) {
  if (auto wrong = take("--layers", parse_layers(arguments.layers), view)) return wrong;
  if (auto wrong = take("--view", parse_camera(*arguments.view), *view.mutable_camera())) return wrong;
  ImageSize size;
  if (auto wrong = take("--picture", parse_image_size(arguments.picture), size)) return wrong;
  view.mutable_camera()->set_vertical_fov_deg(arguments.fov_deg);
  view.set_width_px(size.width);
  view.set_height_px(size.height);
  return std::nullopt;
}

// Sets the options that are more than a number; returns the error, if any.
std::optional<UsageError> set_options(const CutArguments& arguments, v1::Cut& cut) {
  if (arguments.join) {
    double join = 0.0;
    if (auto wrong = take("--join", parse_length(*arguments.join), join)) return wrong;
    cut.set_join_m(join);
  }
  cut.set_method(arguments.method == "element" ? v1::Cut::ELEMENT : v1::Cut::NEIGHBOURHOOD);
  if (arguments.quality == "fine") cut.set_quality(v1::Cut::FINE);
  if (arguments.no_relax) cut.set_relax(false);
  if (arguments.fit) {
    if (auto wrong = take("--fit", parse_fit(*arguments.fit), *cut.mutable_fit())) return wrong;
  }
  if (arguments.view) {
    if (auto wrong = set_view(arguments, *cut.mutable_view())) return wrong;
  }
  if (!arguments.dash) return std::nullopt;
  std::vector<double> lengths;
  if (auto wrong = take("--dash", parse_dash(*arguments.dash), lengths)) return wrong;
  cut.mutable_dash()->Assign(lengths.begin(), lengths.end());
  return std::nullopt;
}

int cut(const Session& session, const CutArguments& arguments) {
  if (!arguments.batch.empty()) {
    return cut_batch(session, arguments.id, arguments.batch, {arguments.at_tick, arguments.is_dry_run});
  }
  v1::CreateCutRequest request;
  request.set_parent("sheets/" + arguments.id);
  *request.mutable_cut() = client::make_cut({}, arguments.options);
  v1::Curve& curve = *request.mutable_cut()->mutable_curve();
  const std::optional<std::string>& file = arguments.drawing ? arguments.drawing : arguments.svg;
  if (!file && arguments.reading.any()) return misuse("--only, --true-size and their like need a drawing");
  if (file) {
    v1::DrawingReading reading;
    if (const auto wrong = take_reading(arguments.reading, reading)) return misuse(wrong->message);
    RealDisk disk;
    Result<v1::Curve> drawing = offline::read_drawing(disk, *file, reading);
    if (!drawing.ok()) return refuse(drawing.error());
    curve = std::move(drawing).value();
  } else if (const auto wrong = set_curve(arguments, curve)) {
    return misuse(wrong->message);
  }
  if (const auto wrong = set_options(arguments, *request.mutable_cut())) return misuse(wrong->message);
  request.set_at_tick(arguments.at_tick);
  request.set_validate_only(arguments.is_dry_run);
  client::Client client = connect(session.server);
  if (file && !arguments.join) request.mutable_cut()->set_join_m(default_join(client, arguments.id, request.cut()));
  v1::CutResult result;
  const grpc::Status status = client.call(&v1::CutService::Stub::CreateCut, client.cuts(), request, result);
  if (!status.ok()) return refuse(status, session.server);
  if (arguments.is_dry_run && !session.json) std::printf("%s\n", kDryRun);
  print(session, result);
  if (arguments.is_dry_run && !session.json) print_tick_time(result);
  return kDone;
}

// Points to the member that an option sets.
using Target =
    std::variant<std::optional<std::string> CutArguments::*, std::string CutArguments::*, double CutArguments::*,
                 std::int64_t CutArguments::*, bool CutArguments::*, double client::CutOptions::*,
                 std::int32_t client::CutOptions::*, std::string client::CutOptions::*>;

struct OptionRow {
  const char* name;
  Target target;
  const char* help;
  const char* needs = nullptr;     // Option of an earlier row that has to be given too.
  const char* excludes = nullptr;  // Option of an earlier row that must not be given too.
  const char* type_name = nullptr;
  std::vector<std::string> choices = {};  // Empty: any value.
};

std::vector<OptionRow> curve_options() {
  return {
      {"--bezier", &CutArguments::bezier, "Cubic Bezier curve: \"x,y x,y x,y x,y\"; 3 more points a further piece"},
      {"--polyline", &CutArguments::polyline, "Straight lines: \"x,y x,y ...\""},
      {"--circle", &CutArguments::circle, "Full circle: \"cx,cy,r\""},
      {"--ellipse", &CutArguments::ellipse, "Full ellipse: \"cx,cy,rx,ry\" or \"cx,cy,rx,ry,DEGREES\""},
      {"--rational", &CutArguments::rational,
       "Rational Bezier curve, quadratic of 3 points or cubic of 4: \"x,y,w x,y,w x,y,w\", weights above 0"},
      {"--path", &CutArguments::path, "SVG path data in metres, y up: \"M 0.2,0.2 H 0.8 A 0.3,0.3 0 0 1 0.2,0.2 Z\""},
      {.name = "--svg", .target = &CutArguments::svg, .help = "As DRAWING", .type_name = value::kFile},
      {.name = "--batch",
       .target = &CutArguments::batch,
       .help = "All cuts of this file, or none: {\"cuts\": [{\"curve\": ...}, ...]}, as `kerf cuts ID --export FILE`\n"
               "writes it; each cut has its own tolerance and angle there. More than 4096 cuts or 1 MiB take\n"
               "several calls: each makes all of its cuts or none, and the first refusal ends the series",
       .type_name = value::kFile},
  };
}

std::vector<OptionRow> other_options() {
  using client::CutOptions;
  return {
      {"--fit", &CutArguments::fit,
       "Scale the curve evenly and centre it in the box \"x0,y0,x1,y1\", or in 90 % of the sheet: \"sheet\""},
      {"--join", &CutArguments::join,
       "Lead ends of lines that nearly meet another line, a cut or the border on to it, if closer than this: 1mm, "
       "0.001\n"
       "(metres), 0 for none (default: a thousandth of the size of a drawing, none for other curves)"},
      {"--dash", &CutArguments::dash, "Perforate: metres cut and left in turn along the curve, \"0.01,0.005[,...]\""},
      {"--dash-offset", &CutOptions::dash_offset, "Start this many metres into the pattern (default 0)", "--dash"},
      {"--width", &CutOptions::width_m,
       "Remove a strip of this width around the curve, metres on the undeformed sheet (default: remove nothing)"},
      {"--component", &CutOptions::component,
       "Cut this component of the scene alone, in its own coordinates (default: the coordinates of the whole sheet)"},
      {"--view", &CutArguments::view,
       "Cut along sight lines: the curve is in pixels of a picture taken from \"EYE TARGET [UP]\", each x,y,z in "
       "metres;\n(0,0) is its top left corner",
       nullptr, "--component"},
      {"--picture", &CutArguments::picture, "Size of that picture in pixels (default 640x360)", "--view"},
      {"--fov", &CutArguments::fov_deg, "Vertical field of view of that picture, degrees (default 40)", "--view"},
      {"--layers", &CutArguments::layers,
       "Which layers of a folded sheet: nearest (what is seen, the default), all, piece (all of the piece\n"
       "seen first), piece:N, or depth:NEAREST,FARTHEST in metres from the camera",
       "--view"},
      {"--at-tick", &CutArguments::at_tick,
       "Cut at the start of this tick instead of at once; `kerf cuts ID` shows the outcome"},
      {.name = "--dry-run",
       .target = &CutArguments::is_dry_run,
       .help = "Predict the cut, and how long a tick would take after it, without cutting",
       .excludes = "--at-tick"},
      {"--tolerance", &CutOptions::tolerance,
       "Largest distance between curve and cut, as a fraction of the edge length there (default 0.02)"},
      {"--min-angle", &CutOptions::min_angle_deg, "Smallest angle of new triangles, degrees (default 20)"},
      {"--tolerance-m", &CutOptions::tolerance_m, "Tolerance in metres, instead of --tolerance"},
      {.name = "--quality",
       .target = &CutArguments::quality,
       .help = "default (20 degrees) or fine (25), instead of --min-angle",
       .choices = {"default", "fine"}},
      {.name = "--method",
       .target = &CutArguments::method,
       .help = "neighbourhood (default), or element: split each crossed triangle by itself, for comparison",
       .choices = {"neighbourhood", "element"}},
      {"--tip-size", &CutOptions::tip_edge_length_m,
       "Edge length at the tips inside the sheet, metres (default: no grading)"},
      {"--tip-grading", &CutOptions::tip_grading,
       "Growth of edges from ring to ring away from the tips, 1.05 to 10 (default 1.5)"},
      {"--no-relax", &CutArguments::no_relax, "Keep existing vertices where they are in material coordinates"},
      {"--max-new-triangles", &CutOptions::max_new_triangles,
       "Refuse a cut that needs more, 1 to 1000000 (default 200000)"},
  };
}

CLI::Option* add(CLI::App& app, const char* name, bool& flag, const char* help) {
  return app.add_flag(name, flag, help);
}
template <typename Value>
CLI::Option* add(CLI::App& app, const char* name, Value& value, const char* help) {
  return app.add_option(name, value, help);
}

CLI::Option& add_option(CLI::App& app, const OptionRow& row, CutArguments& arguments) {
  return *std::visit(
      Overloaded{
          [&](auto CutArguments::*member) { return add(app, row.name, arguments.*member, row.help); },
          [&](auto client::CutOptions::*member) { return add(app, row.name, arguments.options.*member, row.help); },
      },
      row.target);
}

// Adds the options to `group`, a part of `command` or all of it.
void add_options(CLI::App& command, CLI::App& group, const std::vector<OptionRow>& rows, CutArguments& arguments) {
  for (const OptionRow& row : rows) {
    CLI::Option& option = add_option(group, row, arguments);
    if (row.needs != nullptr) option.needs(command.get_option(row.needs));
    if (row.excludes != nullptr) option.excludes(command.get_option(row.excludes));
    if (row.type_name != nullptr) option.type_name(row.type_name);
    if (!row.choices.empty()) option.check(CLI::IsMember(row.choices));
  }
}

}  // namespace

void add_cut_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<CutArguments>();
  CLI::App* command = app.add_subcommand(
      "cut",
      "Cut a sheet along a curve, whole or not at all. Metres in material coordinates: a grid sheet spans (0,0) to\n"
      "(width,height). A curve that misses the sheet is not an error (exit code 0, NO_INTERSECTION).\n"
      "Example: kerf cut demo --bezier \"0.2,0.5 0.4,0.8 0.6,0.2 0.8,0.5\"");
  command->group(group::kCuts);
  add_sheet_id(*command, arguments->id);
  CLI::Option_group* curve = command->add_option_group("curve", "Exactly one of");
  curve
      ->add_option(
          "drawing", arguments->drawing,
          "SVG file: every outline that is painted is cut, fitted into the sheet unless other options place it")
      ->type_name(value::kFile);
  add_options(*command, *curve, curve_options(), *arguments);
  curve->require_option(1);
  add_choice_options(*command, arguments->reading);
  add_unit_option(*command, arguments->reading);
  add_place_options(*command, arguments->reading);
  add_options(*command, *command, other_options(), *arguments);
  CLI::Option* batch = curve->get_option("--batch");
  for (const char* name :
       {"--tolerance", "--min-angle", "--fit", "--dash", "--view", "--width", "--component", "--join"}) {
    batch->excludes(command->get_option(name));
  }
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return cut(session, *arguments); }; });
}

}  // namespace kerf::cli
