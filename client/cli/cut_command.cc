#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cpp/client.h"

namespace kerf::cli {
namespace {

struct CutArguments {
  std::string id;
  std::optional<std::string> bezier;
  std::optional<std::string> polyline;
  std::optional<std::string> circle;
  double tolerance = 0.0;
  double min_angle_deg = 0.0;
};

// The curve of whichever option was given, or what is wrong with it.
Parsed<v1::Curve> curve_of(const CutArguments& arguments) {
  v1::Curve curve;
  if (arguments.circle) {
    const Parsed<v1::Circle> circle = parse_circle(*arguments.circle);
    if (const auto* wrong = std::get_if<UsageError>(&circle)) return UsageError{"--circle: " + wrong->message};
    *curve.mutable_circle() = std::get<v1::Circle>(circle);
    return curve;
  }
  const bool is_bezier = arguments.bezier.has_value();
  const Parsed<std::vector<v1::Vec2>> parsed = parse_points(is_bezier ? *arguments.bezier : *arguments.polyline);
  if (const auto* wrong = std::get_if<UsageError>(&parsed)) {
    return UsageError{(is_bezier ? "--bezier: " : "--polyline: ") + wrong->message};
  }
  const auto& points = std::get<std::vector<v1::Vec2>>(parsed);
  if (is_bezier && (points.size() < 4 || points.size() % 3 != 1)) {
    return UsageError{"--bezier: " + std::to_string(points.size()) +
                      " points: a cubic Bezier curve has 4, each further piece 3 more"};
  }
  if (!is_bezier && points.size() < 2) return UsageError{"--polyline: at least 2 points are needed"};
  auto* target = is_bezier ? curve.mutable_bezier()->mutable_points() : curve.mutable_polyline()->mutable_points();
  target->Assign(points.begin(), points.end());
  return curve;
}

int cut(const Session& session, const CutArguments& arguments) {
  const Parsed<v1::Curve> curve = curve_of(arguments);
  if (const auto* wrong = std::get_if<UsageError>(&curve)) return misuse(wrong->message);
  v1::CreateCutRequest request;
  request.set_parent("sheets/" + arguments.id);
  *request.mutable_cut()->mutable_curve() = std::get<v1::Curve>(curve);
  request.mutable_cut()->set_tolerance(arguments.tolerance);
  request.mutable_cut()->set_min_angle_deg(arguments.min_angle_deg);
  client::Client client(session.server);
  v1::CutResult result;
  const grpc::Status status = client.call(&v1::CutService::Stub::CreateCut, client.cuts(), request, result);
  if (!status.ok()) return refuse(status, session.server);
  std::printf("%s\n", (session.json ? to_script_json(result) : describe(result)).c_str());
  return kDone;
}

}  // namespace

void add_cut_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<CutArguments>();
  CLI::App* command = app.add_subcommand(
      "cut",
      "Cut a sheet along a curve, whole or not at all. Metres in material coordinates: a grid sheet spans (0,0) to\n"
      "(width,height). A curve that misses the sheet is no error (exit code 0, NO_INTERSECTION).\n"
      "Example: kerf cut demo --bezier \"0.2,0.5 0.4,0.8 0.6,0.2 0.8,0.5\"");
  command->add_option("ID", arguments->id, "Name of the sheet")->required();
  CLI::Option_group* curve = command->add_option_group("curve", "Exactly one of");
  curve->add_option("--bezier", arguments->bezier,
                    "Cubic Bezier curve: \"x,y x,y x,y x,y\"; 3 more points a further piece");
  curve->add_option("--polyline", arguments->polyline, "Straight pieces: \"x,y x,y ...\"");
  curve->add_option("--circle", arguments->circle, "Full circle: \"cx,cy,r\"");
  curve->require_option(1);
  command->add_option("--tolerance", arguments->tolerance,
                      "Largest distance between curve and cut, as a fraction of the edge length (default 0.02)");
  command->add_option("--min-angle", arguments->min_angle_deg, "Smallest angle of new triangles, degrees (default 20)");
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return cut(session, *arguments); }; });
}

}  // namespace kerf::cli
