#include "server/service/api/api.h"

#include <algorithm>

#include "google/protobuf/empty.pb.h"
#include "kerf/v1/access_service.pb.h"
#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/files.pb.h"
#include "kerf/v1/interaction.pb.h"
#include "kerf/v1/render.pb.h"
#include "kerf/v1/server.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "kerf/v1/store_service.pb.h"
#include "render/video.h"
#include "server/base/catch_exceptions.h"
#include "server/service/api/access.h"
#include "server/service/api/core.h"
#include "server/service/api/watch_stream.h"
#include "server/service/wire/drawing_codec.h"
#include "server/service/wire/finite_check.h"
#include "server/service/wire/json.h"
#include "server/service/wire/material_codec.h"

namespace kerf::api {
namespace {

Status decode(std::string_view bytes, Encoding encoding, google::protobuf::Message& message) {
  if (encoding == Encoding::kJson) return wire::from_json(bytes, message);
  if (message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return Nothing{};
  return invalid_argument("MALFORMED_MESSAGE", "the request is not a message " + message.GetTypeName());
}

std::string encode(const google::protobuf::Message& message, Encoding encoding) {
  return encoding == Encoding::kJson ? wire::to_json(message) : message.SerializeAsString();
}

// Parses and checks a request, then passes it to `call` with the reply of its response.
template <typename Request, typename Response, typename Call>
Method method_by(std::string path, Api& api, Call call) {
  return {std::move(path), [&api, call](std::string_view bytes, Encoding encoding, const auth::Caller& caller,
                                        Reply<std::string> reply, const std::stop_token& stop) {
            Request request;
            Status status = decode(bytes, encoding, request);
            if (status.ok()) status = wire::check_finite(request);
            if (status.ok()) status = api.allow(caller, request);
            if (!status.ok()) return reply(status.error());
            Reply<Response> encoded = [encoding, reply = std::move(reply)](Result<Response> response) {
              if (!response.ok()) return reply(response.error());
              reply(catch_exceptions([&] { return Result<std::string>(encode(*response, encoding)); }));
            };
            call(request, caller, api.recorded(caller, request, std::move(encoded)), stop);
          }};
}

// `Stop`: nothing, or the stop token of a method that takes one.
template <typename Request, typename Response, typename... Stop>
Method method_of(std::string path, Api& api, void (Api::*method)(const Request&, Reply<Response>, Stop...)) {
  return method_by<Request, Response>(
      std::move(path), api,
      [&api, method](const Request& request, const auth::Caller& /*caller*/, Reply<Response> reply,
                     const std::stop_token& stop) { (api.*method)(request, std::move(reply), Stop(stop)...); });
}

template <typename Request, typename Response>
Method method_of(std::string path, Api& api,
                 void (Api::*method)(const Request&, const auth::Caller&, Reply<Response>)) {
  return method_by<Request, Response>(
      std::move(path), api,
      [&api, method](const Request& request, const auth::Caller& caller, Reply<Response> reply,
                     const std::stop_token& /*stop*/) { (api.*method)(request, caller, std::move(reply)); });
}

std::vector<Method> methods_of(Api& api) {
  std::vector<Method> methods = {
      method_of("/kerf.v1.SheetService/CreateSheet", api, &Api::create_sheet),
      method_of("/kerf.v1.SheetService/GetSheet", api, &Api::get_sheet),
      method_of("/kerf.v1.SheetService/ListSheets", api, &Api::list_sheets),
      method_of("/kerf.v1.SheetService/DeleteSheet", api, &Api::delete_sheet),
      method_of("/kerf.v1.SheetService/PauseSheet", api, &Api::pause_sheet),
      method_of("/kerf.v1.SheetService/ResumeSheet", api, &Api::resume_sheet),
      method_of("/kerf.v1.SheetService/StepSheet", api, &Api::step_sheet),
      method_of("/kerf.v1.SheetService/StepSheets", api, &Api::step_sheets),
      method_of("/kerf.v1.SheetService/ResetSheet", api, &Api::reset_sheet),
      method_of("/kerf.v1.SheetService/SetSheetSpeed", api, &Api::set_sheet_speed),
      method_of("/kerf.v1.SheetService/ExportSheet", api, &Api::export_sheet),
      method_of("/kerf.v1.SheetService/GetSheetState", api, &Api::get_sheet_state),
      method_of("/kerf.v1.SheetService/AnalyzeSheet", api, &Api::analyze_sheet),
      method_of("/kerf.v1.SheetService/SaveState", api, &Api::save_state),
      method_of("/kerf.v1.SheetService/RestoreState", api, &Api::restore_state),
      method_of("/kerf.v1.SheetService/ListStates", api, &Api::list_states),
      method_of("/kerf.v1.SheetService/DeleteState", api, &Api::delete_state),
      method_of("/kerf.v1.FileService/InspectMesh", api, &Api::inspect_mesh),
      method_of("/kerf.v1.CutService/CreateCut", api, &Api::create_cut),
      method_of("/kerf.v1.CutService/CreateCuts", api, &Api::create_cuts),
      method_of("/kerf.v1.CutService/ListCuts", api, &Api::list_cuts),
      method_of("/kerf.v1.CutService/CancelScheduledCuts", api, &Api::cancel_scheduled_cuts),
      method_of("/kerf.v1.CutService/UndoCut", api, &Api::undo_cut),
      method_of("/kerf.v1.CutService/RedoCut", api, &Api::redo_cut),
      method_of("/kerf.v1.CutService/ListPieces", api, &Api::list_pieces),
      method_of("/kerf.v1.InteractionService/GrabPoint", api, &Api::grab_point),
      method_of("/kerf.v1.InteractionService/DragPoint", api, &Api::drag_point),
      method_of("/kerf.v1.InteractionService/ReleasePoint", api, &Api::release_point),
      method_of("/kerf.v1.InteractionService/SetSheetPins", api, &Api::set_sheet_pins),
      method_of("/kerf.v1.InteractionService/SetSheetGravity", api, &Api::set_sheet_gravity),
      method_of("/kerf.v1.InteractionService/SetSheetWind", api, &Api::set_sheet_wind),
      method_of("/kerf.v1.InteractionService/SetSheetMaterial", api, &Api::set_sheet_material),
      method_of("/kerf.v1.InteractionService/SetSheetSelfContact", api, &Api::set_sheet_self_contact),
      method_of("/kerf.v1.RenderService/RenderImage", api, &Api::render_image),
      method_of("/kerf.v1.FileService/InspectDrawing", api, &Api::inspect_drawing),
      method_of("/kerf.v1.ServerService/GetServerInfo", api, &Api::get_server_info),
      method_of("/kerf.v1.AccessService/GetAccess", api, &Api::get_access),
      method_of("/kerf.v1.AccessService/CreateLink", api, &Api::create_link),
      method_of("/kerf.v1.StoreService/GetStoreInfo", api, &Api::get_store_info),
      method_of("/kerf.v1.StoreService/PruneStore", api, &Api::prune_store),
      method_of("/kerf.v1.StoreService/DeleteSetAsideSheet", api, &Api::delete_set_aside_sheet),
      method_of("/kerf.v1.StoreService/BackupStore", api, &Api::backup_store),
  };
  std::sort(methods.begin(), methods.end(), [](const Method& a, const Method& b) { return a.path < b.path; });
  return methods;
}

}  // namespace

Api::Api(host::Host& host, render::Renderer* renderer, ApiOptions options, host::Clock& clock)
    : core_(std::make_shared<ApiCore>(host, renderer, std::move(options), clock)), methods_(methods_of(*this)) {
  host.set_command_listener([core = std::weak_ptr(core_)](const std::string& id, const scene::Command& command,
                                                          const Result<host::CommandResult>& result,
                                                          const host::ScheduleId& schedule_id) {
    if (const auto alive = core.lock()) keep_in_journal(*alive, id, command, result, schedule_id);
  });
  // Each state of a sheet has its list of cuts.
  host.set_attachments({[core = std::weak_ptr(core_)](const std::string& id) {
                          const auto alive = core.lock();
                          return alive ? alive->journal.save(id) : std::string();
                        },
                        [core = std::weak_ptr(core_)](const std::string& id, const std::string& cuts) {
                          if (const auto alive = core.lock()) alive->journal.restore(id, cuts);
                        }});
}

Api::~Api() {
  stop();
  core_->studio.stop();
  core_->picture_worker.stop();
  core_->file_worker.stop();
  core_->analysis_worker.stop();
  core_->store_worker.stop();
}

void Api::inspect_drawing(const v1::InspectDrawingRequest& request, Reply<v1::DrawingReport> reply) {
  if (core_->stopping) return reply(server_stopping());
  reply(catch_exceptions([&] { return wire::inspect_drawing(request); }));
}

void Api::get_server_info(const v1::GetServerInfoRequest& /*request*/, Reply<v1::ServerInfo> reply) {
  if (core_->stopping) return reply(server_stopping());
  const host::HostOptions& host_options = core_->host.options();
  v1::ServerInfo info;
  info.set_version(core_->options.version);
  info.set_instance_id(core_->options.instance_id);
  info.set_renderer(core_->renderer != nullptr ? core_->renderer->description() : "none: none was started");
  info.set_workers(host_options.workers);
  info.set_num_sheets(static_cast<std::int32_t>(core_->host.list().size()));
  info.set_uptime_s(std::chrono::duration<double>(core_->clock.now() - core_->started_at).count());
  info.set_load(core_->host.load());
  for (const std::string_view name : fem::preset_names()) {
    info.add_material_presets(std::string(name));
    v1::Material& material = *info.add_materials();
    material = wire::encode_material(fem::find_preset(name).value());
    material.set_preset(std::string(name));
  }
  v1::Limits& limits = *info.mutable_limits();
  limits.set_max_sheets(host_options.max_sheets);
  limits.set_max_vertices_per_sheet(host_options.max_vertices_per_sheet);
  limits.set_max_queued_commands_per_sheet(host_options.max_queued_commands);
  limits.set_max_request_bytes(core_->options.limits.max_request_bytes);
  limits.set_max_subscribers_per_sheet(core_->options.limits.max_subscribers_per_sheet);
  limits.set_max_unsent_bytes_per_subscriber(core_->options.limits.max_unsent_bytes_per_subscriber);
  limits.set_max_image_streams(core_->options.limits.max_image_streams);
  info.set_video(check_renderer(*core_).ok() && render::video_available());
  limits.set_max_load(host_options.max_load);
  limits.set_max_total_vertices(host_options.max_total_vertices);
  limits.set_max_mesh_upload_bytes(core_->options.limits.max_mesh_upload_bytes);
  limits.set_max_recording_upload_bytes(core_->options.limits.max_recording_upload_bytes);
  reply(std::move(info));
}

std::shared_ptr<WatchSession> Api::watch(const Result<auth::Caller>& caller) {
  return make_watch_session(core_, caller);
}

std::shared_ptr<WatchSession> Api::subscribe(const v1::SubscribeRequest& request, const Result<auth::Caller>& caller) {
  return make_subscription(core_, caller, request);
}

const std::vector<Method>& Api::methods() const {
  return methods_;
}

std::int32_t Api::num_watchers() const {
  return core_->num_watchers;
}

FrameCounts Api::frame_counts() const {
  const stream::FrameCounters& counters = core_->hub.counters();
  return {counters.encoded, counters.sent};
}

const Limits& Api::limits() const {
  return core_->options.limits;
}

void Api::remember(std::vector<host::StoredRequest> requests) {
  for (host::StoredRequest& each : requests) {
    core_->requests.remember(std::move(each.key), each.body_hash, std::move(each.reply));
  }
}

void Api::stop() {
  core_->stopping = true;
  core_->hub.stop();
  core_->studio.close();
  core_->analysis_worker.close();  // The analysis in progress checks `stopping`.
  // Refuses waiting pictures and files: the transports wait for every answer, and making them all could outlast a stop.
  core_->picture_worker.close();
  core_->file_worker.close();
  core_->stop_backup.request_stop();
  core_->store_worker.close();
  core_->streams.notify_stop();
}

}  // namespace kerf::api
