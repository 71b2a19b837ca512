#include "client/cli/output.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <nlohmann/json.hpp>

#include "client/cli/server_names.h"
#include "client/cli/suggestions.h"
#include "client/cpp/failure.h"
#include "server/service/wire/error_codec.h"
#include "server/service/wire/json.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;
using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

void make_numbers(Json& json, const Descriptor& type);

void make_number(Json& json, const FieldDescriptor& field) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    make_numbers(json, *field.message_type());
  } else if (json.is_string() && field.cpp_type() == FieldDescriptor::CPPTYPE_INT64) {
    json = std::stoll(json.get<std::string>());
  } else if (json.is_string() && field.cpp_type() == FieldDescriptor::CPPTYPE_UINT64) {
    json = std::stoull(json.get<std::string>());
  }
}

void make_numbers(Json& json, const Descriptor& type) {
  if (!json.is_object()) return;
  for (auto& [name, value] : json.items()) {
    const FieldDescriptor* field = type.FindFieldByName(name);
    if (field == nullptr || field->is_map()) continue;
    if (field->is_repeated()) {
      for (Json& element : value) make_number(element, *field);
    } else {
      make_number(value, *field);
    }
  }
}

const char* name_of(v1::Sheet::RunState state) {
  switch (state) {
    case v1::Sheet::RUNNING:
      return "running";
    case v1::Sheet::PAUSED:
      return "paused";
    case v1::Sheet::SLEEPING:
      return "sleeping";
    case v1::Sheet::FAILED:
      return "FAILED, frozen at its last good tick";
    default:
      return "unknown";
  }
}

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::string text(static_cast<std::size_t>(std::snprintf(nullptr, 0, pattern, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, pattern, values...);
  return text;
}

std::string millimetres(double metres) {
  const double mm = 1e3 * metres;
  return format(mm < 100.0 ? "%.2g mm" : "%.0f mm", mm);
}

std::string notes(const v1::CutResult& result) {
  std::string text;
  for (const std::string& warning : result.warnings()) text += "\n  note: " + warning;
  return text;
}

// Describes the time of a tick and its parts, the largest first.
std::string tick_parts(const v1::TickEstimate& estimate) {
  std::vector<std::pair<double, std::string>> parts;
  for (const auto& [part, us] : estimate.parts_us()) parts.emplace_back(us, part);
  std::sort(parts.begin(), parts.end(), std::greater<>());
  std::string text = format("\n  a tick takes %.3g ms of the %.3g ms available", 1e-3 * estimate.total_us(),
                            1e-3 * estimate.budget_us());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    text += format("%s %s %.0f %%", i == 0 ? ":" : ",", parts[i].second.c_str(),
                   100.0 * parts[i].first / estimate.total_us());
  }
  return text;
}

// Lists the server's measurements and counts, one per line.
std::string measurements(const v1::Sheet& sheet) {
  std::string text = tick_parts(sheet.tick_estimate()) + "\n  " + sheet.integrator();
  if (sheet.has_local_inertia()) {
    const v1::LocalInertia& inertia = sheet.local_inertia();
    text += format("\n  local inertia: %d %s of %d vertices, the largest of %d; %.0f substeps a tick in place of %.0f",
                   inertia.clusters(), inertia.clusters() == 1 ? "cluster" : "clusters", inertia.vertices(),
                   inertia.largest_cluster_vertices(), inertia.planned_substeps(), inertia.plain_substeps());
  }
  if (sheet.linear_iterations() > 0) text += format("\n  linear residual %.2g", sheet.linear_residual());
  if (!sheet.state_hash().empty()) text += "\n  state hash " + sheet.state_hash();
  if (sheet.has_resimulated_from_tick()) {
    text += format(
        "\n  since the restart it moves unlike before, from tick %lld on: another build or processor computes it",
        static_cast<long long>(sheet.resimulated_from_tick()));
  }
  if (sheet.intersections() > 0) {
    text += format("\n  %lld %s", static_cast<long long>(sheet.intersections()),
                   sheet.intersections() == 1 ? "intersection" : "intersections");
  }
  for (const v1::SheetComponent& component : sheet.components()) {
    const v1::MaterialBox& box = component.extent();
    text += format("\n  component %s: %g,%g to %g,%g, offset %g,%g; vertices %d to %d", component.name().c_str(),
                   box.min().x(), box.min().y(), box.max().x(), box.max().y(), component.offset().x(),
                   component.offset().y(), component.first_vertex(),
                   component.first_vertex() + component.num_vertices() - 1);
  }
  std::string flags;
  for (const auto& [flag, ticks] : by_name(sheet.flagged_ticks())) {
    flags +=
        format("%s %s %lld", flags.empty() ? "\n  ticks flagged" : ",", flag.c_str(), static_cast<long long>(ticks));
  }
  return text + flags;
}

// Describes the shapes of the new triangles.
std::string shapes(const v1::CutResult& result) {
  const v1::CutQuality& quality = result.quality();
  std::string text = format(
      "\n  %d triangles crossed, %d new triangles: smallest angle %.1f degrees (mean %.1f), l_max/h_min up to %.2f "
      "(%.2f),\n"
      "  l_max/l_min up to %.2f (%.2f), smallest height %.3g m, %d below the contract",
      result.crossed_triangles(), result.new_triangles(), result.min_angle_deg(), quality.mean_min_angle_deg(),
      quality.max_aspect(), quality.mean_aspect(), quality.max_edge_ratio(), quality.mean_edge_ratio(),
      quality.min_height_m(), quality.below_contract());
  if (const v1::StrandQuality& strands = quality.strands(); strands.below_angle() > 0) {
    const int num_wide = strands.below_angle() - strands.narrow_below_angle();
    text += format("\n  near strands: %d triangles below the angle, %d of them in narrow gaps", strands.below_angle(),
                   strands.narrow_below_angle());
    if (num_wide > 0) {
      text += format("; smallest angle outside of these gaps %.1f degrees, asked for %.1f", strands.min_angle_deg(),
                     strands.asked_angle_deg());
    }
  }
  for (const v1::SharpCorner& corner : quality.corners()) {
    text += format("\n  corner of %.1f degrees at (%.6g, %.6g) m: %d triangles below the angle", corner.angle_deg(),
                   corner.position().x(), corner.position().y(), corner.elements_below());
  }
  if (quality.corners_total() > quality.corners_size()) {
    text += format("\n  and %d more corners", quality.corners_total() - quality.corners_size());
  }
  return text;
}

// Describes names, layers, gaps, pieces and times of an applied cut.
std::string outcome(const v1::CutResult& result) {
  // A dry run has no name.
  std::string text = format(
      "\n  %s%stopology version %d, state hash %s\n"
      "  queued %.0f us, cut %.0f us, model update %.0f us; a tick takes %.3g ms, %.3g before",
      result.name().c_str(), result.name().empty() ? "" : ", ", result.topology_version(), result.state_hash().c_str(),
      result.queued_us(), result.cut_us(), result.update_us(), 1e-3 * result.tick_after_us(),
      1e-3 * result.tick_before_us());
  for (const v1::CutLayer& layer : result.layers()) {
    text += format("\n  layer: piece %d, %.4g m long, %.4g to %.4g m from the camera, %s", layer.piece(),
                   layer.length_m(), layer.nearest_m(), layer.farthest_m(), layer.faces_camera() ? "front" : "back");
  }
  // Gaps that snapping closed are below the cut's tolerance, and not worth a line.
  if (result.joined_ends() > 0) {
    text += format("\n  ends joined to another line, a cut or the border: %d, over up to %s", result.joined_ends(),
                   millimetres(result.widest_join_m()).c_str());
  }
  if (result.merged_segments() > 0) {
    text += format("\n  parts of the curve too short to cut, left out: %d", result.merged_segments());
  }
  for (const v1::PieceSplit& split : result.split_pieces()) {
    text += "\n  piece " + std::to_string(split.piece()) + (split.children().empty() ? " is gone" : " fell apart:");
    for (const v1::Piece& child : split.children()) text += "\n    " + describe(child);
  }
  return text;
}

// Returns the text in the message's first quotation marks.
std::string quoted_in(const std::string& message) {
  const std::size_t begin = message.find('"') + 1;
  return begin == 0 ? std::string() : message.substr(begin, message.find('"', begin) - begin);
}

bool in_json = false;

// Prints an error. `line` is for people; `failure` has the parts for programs.
void complain(const std::string& line, const std::string& code, const Error& failure) {
  if (in_json) {
    const Json error{
        {"code", code}, {"reason", failure.reason}, {"message", failure.message}, {"field", failure.field}};
    std::fprintf(stderr, "%s\n", Json{{"error", error}}.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
  } else {
    std::fprintf(stderr, "kerf: %s\n", line.c_str());
  }
}

std::string sheets_near(const std::string& id, const ServerTarget& server) {
  const std::string near = did_you_mean(near_names(id, sheet_ids(server)));
  return near.empty() ? "; `kerf sheet list` lists all sheets" : near;
}

}  // namespace

std::string to_script_json(const google::protobuf::Message& message, int indent) {
  Json json = Json::parse(wire::to_json(message));
  make_numbers(json, *message.GetDescriptor());
  return json.dump(indent);
}

void refuse_in_json() {
  in_json = true;
}

int refuse(const grpc::Status& status, const ServerTarget& server) {
  return refuse(client::failure_of(status), server);
}

int refuse(client::Failure failure, const ServerTarget& server) {
  std::string line = client::describe(failure);
  if (failure.code == grpc::StatusCode::UNAVAILABLE && failure.reason.empty()) {
    for (const char* closed : {"Socket closed", "reset by peer", "Broken pipe"}) {
      if (failure.message.find(closed) == std::string::npos) continue;
      failure.message +=
          "; a server that asks for TLS (--tls-ca), or for a certificate (--tls-cert), closes connections so";
      break;
    }
    failure.message = "no Kerf server answers at " + server.address +
                      ": start one with kerfd or deploy/run, or name another with --server or KERF_SERVER (" +
                      failure.message + ")";
    line = failure.message;
  }
  if (failure.reason == "TOKEN_MISSING") {
    const std::string remedy = "; give it with --token-file FILE or KERF_TOKEN_FILE";
    failure.message += remedy;
    line += remedy;
  }
  if (failure.reason == "SHEET_NOT_FOUND") {
    const std::string near = sheets_near(quoted_in(failure.message), server);
    failure.message += near;
    line += near;
  }
  complain(line, client::name_of(failure.code), internal_error(failure.reason, failure.message, failure.field));
  return kRefused;
}

int refuse(const Error& error) {
  const std::string field = error.field.empty() ? "" : " [field: " + error.field + "]";
  complain(error.message + field + " (" + error.reason + ")", std::string(wire::status_name(error.code)), error);
  return kRefused;
}

int misuse(const std::string& message) {
  complain(message, "INVALID_ARGUMENT", invalid_argument("WRONG_USAGE", message));
  return kWrongUsage;
}

int refuse_ended(const v1::Ended& ended, std::int64_t count, const std::string& of_what) {
  return refuse(unavailable(
      v1::Ended::Reason_Name(ended.reason()),
      "the server ended the stream after " + std::to_string(count) + " " + of_what + ": " + ended.message()));
}

std::map<std::string, std::int64_t> by_name(const google::protobuf::Map<std::string, std::int64_t>& flagged_ticks) {
  return {flagged_ticks.begin(), flagged_ticks.end()};
}

void print(const Session& session, const v1::Sheet& sheet) {
  std::printf("%s\n", (session.json ? to_script_json(sheet) : describe(sheet, session.verbose)).c_str());
}

void print(const Session& session, const v1::CutResult& result) {
  std::printf("%s\n", (session.json ? to_script_json(result) : describe(result, session.verbose)).c_str());
}

void print(const Session& session, const v1::InteractionResponse& response) {
  if (session.json) {
    std::printf("%s\n", to_script_json(response).c_str());
  } else {
    std::printf("set at tick %lld\n", static_cast<long long>(response.tick()));
  }
}

std::string time_of(std::int64_t unix_us) {
  const std::time_t seconds = unix_us / 1'000'000;
  std::tm parts{};
  localtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &parts);
  return text.data();
}

std::string describe(const v1::Sheet& sheet, bool verbose) {
  std::string text =
      format("%-20s %-8s tick %-8lld %6d vertices %6d triangles %3d %s  since %s  x%.2f real time",
             sheet.name().c_str(), name_of(sheet.run_state()), static_cast<long long>(sheet.tick()),
             sheet.num_vertices(), sheet.num_triangles(), sheet.pieces(), sheet.pieces() == 1 ? "piece" : "pieces",
             time_of(sheet.created_unix_us()).c_str(), sheet.real_time_factor());
  if (sheet.strained_share() > 0.0) {
    text += format("\n  %.2g %% of the area is beyond its strain limit", 100.0 * sheet.strained_share());
  }
  if (sheet.softening().factor() > 1) {
    text += format("\n  membrane %d times softer to keep up with real time; expected error %s",
                   sheet.softening().factor(), millimetres(sheet.softening().expected_error_m()).c_str());
  }
  const bool is_stepped = sheet.run_state() == v1::Sheet::RUNNING || sheet.run_state() == v1::Sheet::PAUSED;
  if (is_stepped && !sheet.tick_estimate().advice().empty()) text += "\n  " + sheet.tick_estimate().advice();
  return verbose ? text + measurements(sheet) : text;
}

std::string describe(const v1::CutResult& result, bool verbose) {
  const std::string pieces = format("%d %s", result.pieces(), result.pieces() == 1 ? "piece" : "pieces");
  const auto tick = static_cast<long long>(result.tick());
  if (result.status() == v1::CutResult::SCHEDULED) {
    const std::string number = result.scheduled_name().substr(result.scheduled_name().rfind('/') + 1);
    return format("SCHEDULED for tick %lld; `kerf cuts` shows the outcome, `--cancel %s` cancels it", tick,
                  number.c_str());
  }
  if (result.status() == v1::CutResult::NO_INTERSECTION) {
    const char* why =
        result.closed_gaps() > 0 ? "follows an earlier cut or the border" : "misses the sheet or is too small";
    return format("Nothing was cut: the curve %s (%s, tick %lld)", why, pieces.c_str(), tick) + notes(result);
  }
  constexpr double kRounding = 1e-9;  // m
  const std::string deviation = result.deviation_m() < kRounding
                                    ? "exactly along the curve"
                                    : format("at most %s off the curve", millimetres(result.deviation_m()).c_str());
  std::string text = format("Cut: %s, %d new vertices, %s (tick %lld)", pieces.c_str(), result.new_vertices(),
                            deviation.c_str(), tick);
  if (result.has_removed()) {
    const v1::Removed& removed = result.removed();
    text +=
        format("\n  removed: %.6g m^2, %.6g kg, %d vertices", removed.area_m2(), removed.mass_kg(), removed.vertices());
  }
  if (verbose) text += shapes(result) + outcome(result);
  return text + notes(result);
}

std::string describe(const v1::Piece& piece) {
  return format("piece %-4lld of %-4lld %.4g m^2, %.4g kg, %d triangles, centroid (%.4g, %.4g) m",
                static_cast<long long>(piece.id()), static_cast<long long>(piece.parent()), piece.area_m2(),
                piece.mass_kg(), piece.num_triangles(), piece.centroid().x(), piece.centroid().y());
}

}  // namespace kerf::cli
