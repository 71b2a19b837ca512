#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "kerf/v1/sheets.pb.h"
#include "render/renderer.h"
#include "server/base/catch_exceptions.h"
#include "server/service/api/api.h"
#include "server/service/api/audience.h"
#include "server/service/api/cut_journal.h"
#include "server/service/api/open_streams.h"
#include "server/service/api/request_log.h"
#include "server/service/api/resource_names.h"
#include "server/service/api/stream_hub.h"
#include "server/service/host/clock.h"
#include "server/service/host/host.h"
#include "server/service/picture/background_worker.h"
#include "server/service/picture/picture_studio.h"

namespace kerf::api {

// Threads that wait for the store: one for a backup, the other for calls beside it.
inline constexpr std::size_t kStoreThreads = 2;

// Threads of the picture studio: one draws or waits for the graphics device while the other encodes.
inline constexpr std::size_t kStudioThreads = 2;

// Holds the state shared by the methods of an Api and its streams.
struct ApiCore {
  ApiCore(host::Host& the_host, render::Renderer* the_renderer, ApiOptions the_options, host::Clock& the_clock)
      : host(the_host),
        renderer(the_renderer),
        options(std::move(the_options)),
        clock(the_clock),
        started_at(the_clock.now()),
        requests(options.limits.max_remembered_requests, options.limits.max_remembered_bytes),
        audience(std::make_shared<Audience>(the_clock)),
        hub(the_host, options.limits.max_subscribers_per_sheet, options.instance_id, the_clock),
        studio(the_renderer, pictures, the_clock, kStudioThreads),
        picture_worker(options.limits.max_waiting_pictures),
        file_worker(options.limits.max_waiting_files),
        analysis_worker(options.limits.max_waiting_analyses),
        store_worker(options.limits.max_waiting_store_calls, kStoreThreads) {}

  host::Host& host;
  render::Renderer* const renderer;  // May be null.
  const ApiOptions options;
  host::Clock& clock;
  const host::Nanoseconds started_at;
  std::atomic<bool> stopping{false};
  std::atomic<std::int32_t> num_watchers{0};
  std::atomic<std::int64_t> uploading_bytes{0};  // Bytes declared by uploads in progress.
  std::atomic<std::int32_t> recordings_sent{0};  // Recordings being made or sent.
  RequestLog requests;
  CutJournal journal;
  std::atomic<std::int32_t> num_image_streams{0};
  picture::PictureCounters pictures;
  const std::shared_ptr<Audience> audience;
  StreamHub hub;
  picture::PictureStudio studio;  // Draws for image streams, on its own threads.
  picture::BackgroundWorker
      picture_worker;  // Draws single pictures. Stopped by ~Api, so that it never ends on its own thread.
  picture::BackgroundWorker file_worker;      // Encodes exports and recordings. Stopped by ~Api.
  picture::BackgroundWorker analysis_worker;  // Runs analyses. Stopped by ~Api.
  std::atomic<bool> is_backing_up{false};
  std::stop_source stop_backup;
  picture::BackgroundWorker store_worker;  // Waits for the store. Stopped by ~Api.

  OpenStreams streams;
};

// Returns kUnavailable, the answer to all calls after Api::stop().
Error server_stopping();

// Checks that there is a renderer. kUnavailable RENDERER_UNAVAILABLE, with the reason.
Status check_renderer(const ApiCore& core);

// Records what became of a call of a caller, and shows it to those who watch the sheet. `sheet`: its id; empty: none.
// `request_id`: empty if it has none.
void record(const ApiCore& core, const auth::Caller& caller, const std::string& call, const std::string& sheet,
            const std::string& request_id, const Status& outcome);

// Counts a stream of the caller's tenant until the result is destroyed. Errors of Tenants::open_stream().
Result<std::shared_ptr<const void>> open_stream(const ApiCore& core, const auth::Caller& caller, bool pictures);

// Implements Api::create_sheet(); moves the mesh out of the request.
void make_sheet(const std::shared_ptr<ApiCore>& core, v1::CreateSheetRequest request, Reply<v1::Sheet> reply,
                const std::stop_token& stop);

// Returns the sheet id that a request names in `field`. Errors: the server is stopping, or the name is malformed.
Result<std::string> addressed_sheet(const ApiCore& core, const std::string& name, const char* field);

// Sets `field` in a kNotFound error of the host that names no field.
Error with_field(Error error, const char* field);

// Checks the id of a new sheet; empty means none is given. kInvalidArgument SHEET_ID.
Status check_sheet_id(const std::string& id);

// Checks a request_id. kInvalidArgument REQUEST_ID_TOO_LONG.
Status check_request_id(const std::string& request_id);

// Adds commands done without a caller to the journal: cuts, resets, undos, redos, and refused scheduled cuts. Called
// for each command that the host's listener receives; methods add the commands of their callers themselves.
void keep_in_journal(ApiCore& core, const std::string& sheet_id, const scene::Command& command,
                     const Result<host::CommandResult>& result, const host::ScheduleId& schedule_id);

// Encodes a kerf.v1.Sheet.
v1::Sheet encode_sheet(const host::SheetStatus& status);

// Returns a callback that replies with the sheet's status; errors name `field`.
host::Callback<host::SheetStatus> sheet_reply(Reply<v1::Sheet> reply, const char* field);

// Names a request in the RequestLog and in a store; without a request_id the key is empty.
struct RequestKey {
  std::string key;
  std::uint64_t body_hash = 0;

  // Returns the name under which the host stores the request, with the answer that `encode` makes of its result.
  template <typename T, typename Encode>
  [[nodiscard]] host::RequestName<T> answered_by(Encode encode) const {
    if (key.empty()) return nullptr;
    return std::make_shared<const host::NamedRequest<T>>(host::NamedRequest<T>{
        key, body_hash, [encode = std::move(encode)](const T& result) { return encode(result).SerializeAsString(); }});
  }
};

// `method` separates the ids of different methods.
template <typename Request>
RequestKey key_of(const char* method, const Request& request) {
  if (request.request_id().empty()) return {};
  return {std::string(method) + ' ' + request.request_id(), RequestLog::hash_of(request.SerializeAsString())};
}

// Calls `perform` once for each request_id: see RequestLog. `method` separates the ids of different methods. `caller`
// is triggered when the caller leaves. The token passed to `perform` is triggered once all callers that wait for its
// reply have left.
template <typename Response, typename Request>
void idempotent_while_wanted(const std::shared_ptr<ApiCore>& core, const char* method, const Request& request,
                             Reply<Response> reply, const std::stop_token& caller,
                             const std::function<void(Reply<Response>, const std::stop_token&)>& perform) {
  if (request.request_id().empty()) return perform(std::move(reply), caller);
  if (const Status status = check_request_id(request.request_id()); !status.ok()) return reply(status.error());
  const auto [key, body_hash] = key_of(method, request);
  const auto repeat = [reply](const RequestLog::Outcome& known) {
    if (!known.ok()) return reply(known.error());
    Response response;
    response.ParseFromString(*known);
    reply(std::move(response));
  };
  const std::optional<std::stop_token> all_left = core->requests.begin(key, body_hash, repeat, caller);
  if (!all_left) return;
  const auto finish = [core, key = key, reply](Result<Response> result) {
    core->requests.finish(
        key, result.ok() ? RequestLog::Outcome(result->SerializeAsString()) : RequestLog::Outcome(result.error()));
    reply(std::move(result));
  };
  perform(finish, *all_left);
}

// Calls `perform` as idempotent_while_wanted() does, for work that continues even if no caller waits for it.
template <typename Response, typename Request>
void idempotent(const std::shared_ptr<ApiCore>& core, const char* method, const Request& request, Reply<Response> reply,
                const std::function<void(Reply<Response>)>& perform) {
  idempotent_while_wanted<Response>(
      core, method, request, std::move(reply), {},
      [&](Reply<Response> answer, const std::stop_token& /*never*/) { perform(std::move(answer)); });
}

// Runs `work` on a background worker and replies with its result, or with its exception as an Error (see
// catch_exceptions()). `full`: the reply if too much work waits. Replies kUnavailable if the server stops first.
template <typename Made>
void in_background(picture::BackgroundWorker& worker, const Reply<Made>& reply, std::function<Result<Made>()> work,
                   const Error& full) {
  switch (worker.submit([reply, work = std::move(work)] { reply(catch_exceptions(work)); },
                        [reply] { reply(server_stopping()); })) {
    case picture::BackgroundWorker::Outcome::kTaken:
      return;
    case picture::BackgroundWorker::Outcome::kStopped:
      return reply(server_stopping());
    case picture::BackgroundWorker::Outcome::kFull:
      return reply(full);
  }
}

// Return kResourceExhausted for too many waiting pictures, files or analyses.
Error too_many_pictures(const ApiCore& core);
Error too_many_files(const ApiCore& core);
Error too_many_analyses(const ApiCore& core);

// Copies a sheet between two ticks. kResourceExhausted SHEET_TOO_LARGE if it has more than
// Limits::max_analyzed_vertices.
void copy_sheet(const std::shared_ptr<ApiCore>& core, const std::string& sheet_id, const char* field,
                std::function<void(Result<std::shared_ptr<sheet::Sheet>>)> done);

// Calls `look` on the sheet's strand between two ticks. Passes its result, or its exception as an Error (see
// catch_exceptions()), to `done`.
template <typename Found>
void inspect(const std::shared_ptr<ApiCore>& core, const std::string& sheet_id,
             std::function<Found(const sheet::Sheet&)> look, const char* field,
             std::function<void(Result<Found>)> done) {
  auto found = std::make_shared<std::optional<Result<Found>>>();
  core->host.inspect(
      sheet_id,
      [found, look = std::move(look)](const sheet::Sheet& sheet) {
        found->emplace(catch_exceptions([&] { return Result<Found>(look(sheet)); }));
      },
      [found, field, done = std::move(done)](const Status& status) {
        if (!status.ok()) return done(with_field(status.error(), field));
        done(std::move(**found));
      });
}

}  // namespace kerf::api
