#include "server/service/ws/file_routes.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <system_error>
#include <utility>

#include "kerf/v1/files.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "server/base/catch_exceptions.h"
#include "server/service/api/access.h"
#include "server/service/api/upload.h"
#include "server/service/wire/finite_check.h"
#include "server/service/wire/json.h"
#include "server/service/wire/mesh_source_codec.h"
#include "server/service/ws/router.h"

namespace kerf::ws {
namespace {

constexpr std::string_view kSheets = "/sheets";
constexpr std::string_view kMeshes = "/meshes";
constexpr std::string_view kRecordings = "/recordings";
constexpr std::string_view kRecordingEnding = ".rec";

// Decodes %HH; returns false if HH is not a number.
bool decode_escape(std::string_view digits, char& byte) {
  unsigned value = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  byte = static_cast<char>(value);
  return digits.size() == 2 && fault == std::errc() && end == digits.data() + 2;
}

Result<std::string> percent_decoded(std::string_view text, std::string_view name) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char byte = text[i] == '+' ? ' ' : text[i];
    if (text[i] == '%') {
      if (!decode_escape(text.substr(i + 1, 2), byte)) {
        return invalid_argument("MALFORMED_QUERY",
                                std::string(name) + " has a % without two hexadecimal digits after it",
                                std::string(name));
      }
      i += 2;
    }
    decoded.push_back(byte);
  }
  return decoded;
}

enum class MeshFormat { kObj, kPly };

Result<MeshFormat> read_format(const HttpRequest& request) {
  KERF_TRY_ASSIGN(const std::string format, query_parameter(request.target, "format"));
  if (format == "obj") return MeshFormat::kObj;
  if (format == "ply") return MeshFormat::kPly;
  return invalid_argument("UNKNOWN_FORMAT", "format must be obj or ply", "format");
}

// Reads a message from the parameter "request"; leaves it empty without that.
Status read_request(const HttpRequest& request, google::protobuf::Message& message) {
  KERF_TRY_ASSIGN(const std::string json, query_parameter(request.target, "request"));
  return json.empty() ? Status(Nothing{}) : wire::from_json(json, message);
}

Result<v1::SheetUpload> read_sheet_upload(const HttpRequest& request) {
  KERF_TRY_ASSIGN(const MeshFormat format, read_format(request));
  v1::SheetUpload start;
  KERF_TRY(read_request(request, *start.mutable_sheet()));
  v1::Scene& scene = *start.mutable_sheet()->mutable_scene();
  if (format == MeshFormat::kObj) {
    scene.mutable_obj();
  } else {
    scene.mutable_ply();
  }
  return start;
}

// Takes the file out of the request.
Result<v1::InspectMeshRequest> take_inspection(HttpRequest& request) {
  KERF_TRY_ASSIGN(const MeshFormat format, read_format(request));
  v1::InspectMeshRequest inspection;
  KERF_TRY(read_request(request, inspection));
  KERF_TRY(wire::check_finite(inspection));
  const bool is_other = format == MeshFormat::kObj ? inspection.has_ply() : inspection.has_obj();
  if (is_other || !inspection.obj().text().empty() || !inspection.ply().data().empty()) {
    return invalid_argument("UPLOAD_OF_WHAT",
                            "the request may only say how a file of this format is read: the body is it", "request");
  }
  const bool is_obj = format == MeshFormat::kObj;
  KERF_TRY_ASSIGN(std::string file, wire::unpacked_mesh(std::move(request.body), is_obj ? "OBJ" : "PLY", "request"));
  if (is_obj) {
    inspection.mutable_obj()->set_text(std::move(file));
  } else {
    inspection.mutable_ply()->set_data(std::move(file));
  }
  return inspection;
}

Result<v1::RecordingUpload> read_recording_upload(const HttpRequest& request) {
  KERF_TRY_ASSIGN(const std::string sheet, query_parameter(request.target, "sheet"));
  KERF_TRY_ASSIGN(const std::string paused, query_parameter(request.target, "paused"));
  if (!paused.empty() && paused != "true" && paused != "false") {
    return invalid_argument("UNKNOWN_VALUE", "paused must be true or false", "paused");
  }
  v1::RecordingUpload start;
  start.set_sheet_id(sheet);
  start.set_paused(paused == "true");
  return start;
}

// Begins the upload of a request. `Start`: SheetUpload or RecordingUpload.
template <typename Start>
Result<std::unique_ptr<api::Upload>> begin_upload(
    api::Api& api, const Result<auth::Caller>& caller, Result<Start> start, std::size_t num_bytes,
    Result<std::unique_ptr<api::Upload>> (api::Api::*method)(const Start&)) {
  KERF_TRY(caller);
  KERF_TRY(start);
  KERF_TRY(api.allow(*caller, *start));
  start->set_num_bytes(static_cast<std::int64_t>(num_bytes));
  return api::recorded_upload((api.*method)(*start), api.recorder(*caller, *start));
}

}  // namespace

Result<std::string> query_parameter(std::string_view target, std::string_view name) {
  const std::size_t question = target.find('?');
  std::string_view query = question == std::string_view::npos ? std::string_view() : target.substr(question + 1);
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(pair.size() + 1, query.size()));
    if (pair.substr(0, pair.find('=')) != name) continue;
    return percent_decoded(pair.substr(std::min(name.size() + 1, pair.size())), name);
  }
  return std::string();
}

bool FileRoutes::is_download(std::string_view path) {
  return path.starts_with(std::string(kSheets) + "/") && path.ends_with(kRecordingEnding);
}

std::int64_t FileRoutes::upload_limit(std::string_view path) const {
  if (path == kSheets || path == kMeshes) return api_.limits().max_mesh_upload_bytes;
  return path == kRecordings ? api_.limits().max_recording_upload_bytes : 0;
}

void FileRoutes::download(const Result<auth::Caller>& caller, std::string_view path,
                          std::function<void(HttpResponse)> done) const {
  if (!caller.ok()) return done(refusal(caller.error()));
  const std::string_view name = path.substr(1, path.size() - 1 - kRecordingEnding.size());  // sheets/ID
  const std::string file = std::string(path.substr(kSheets.size() + 1));
  v1::GetSheetRecordingRequest request;
  request.set_name(std::string(name));
  if (const Status allowed = api_.allow(*caller, request); !allowed.ok()) return done(refusal(allowed.error()));
  api_.get_sheet_recording(request, [file, done = std::move(done)](Result<std::shared_ptr<const std::string>> reply) {
    if (!reply.ok()) return done(refusal(reply.error()));
    done({200,
          "application/octet-stream",
          *reply,
          {{"Cache-Control", "no-store"}, {"Content-Disposition", "attachment; filename=\"" + file + "\""}}});
  });
}

void FileRoutes::upload(const Result<auth::Caller>& caller, HttpRequest request, std::function<void(HttpResponse)> done,
                        const std::stop_token& stop) const {
  const std::string_view path = std::string_view(request.target).substr(0, request.target.find('?'));
  if (path == kMeshes) return inspect(caller, std::move(request), std::move(done), stop);
  const std::size_t size = request.body.size();
  Result<std::unique_ptr<api::Upload>> upload =
      path == kSheets ? begin_upload(api_, caller, read_sheet_upload(request), size, &api::Api::upload_sheet)
                      : begin_upload(api_, caller, read_recording_upload(request), size, &api::Api::replay_recording);
  if (!upload.ok()) return done(refusal(upload.error()));
  if (const Status taken = (*upload)->append(std::move(request.body)); !taken.ok()) return done(refusal(taken.error()));
  const auto answer = [done = std::move(done)](Result<v1::Sheet> sheet) {
    if (!sheet.ok()) return done(refusal(sheet.error()));
    done({200,
          "application/json",
          std::make_shared<const std::string>(wire::to_json(*sheet)),
          {{"Cache-Control", "no-store"}}});
  };
  (*upload)->finish(answer, stop);
}

void FileRoutes::inspect(const Result<auth::Caller>& caller, HttpRequest request,
                         std::function<void(HttpResponse)> done, const std::stop_token& stop) const {
  if (!caller.ok()) return done(refusal(caller.error()));
  Result<std::shared_ptr<const api::UploadRoom>> room =
      api_.reserve_upload(static_cast<std::int64_t>(request.body.size()));
  if (!room.ok()) return done(refusal(room.error()));
  Result<v1::InspectMeshRequest> inspection = take_inspection(request);
  if (!inspection.ok()) return done(refusal(inspection.error()));
  if (const Status allowed = api_.allow(*caller, *inspection); !allowed.ok()) return done(refusal(allowed.error()));
  const auto answer = [done = std::move(done), room = *room](Result<v1::MeshReport> report) {
    if (!report.ok()) return done(refusal(report.error()));
    const Result<std::string> json = catch_exceptions([&] { return Result<std::string>(wire::to_json(*report)); });
    if (!json.ok()) return done(refusal(json.error()));
    done({200, "application/json", std::make_shared<const std::string>(*json), {{"Cache-Control", "no-store"}}});
  };
  api_.inspect_mesh(std::move(*inspection), answer, stop);
}

}  // namespace kerf::ws
