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
#include "server/base/caught.h"
#include "server/service/api/api.h"
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

// One draws or waits for the graphics device while another encodes.
inline constexpr std::size_t kStudioThreads = 2;

// What the methods of an Api and its streams share.
struct ApiCore {
  ApiCore(host::Host& the_host, render::Renderer* the_renderer, ApiOptions the_options, host::Clock& the_clock)
      : host(the_host),
        renderer(the_renderer),
        options(std::move(the_options)),
        clock(the_clock),
        started_at(the_clock.now()),
        requests(options.limits.max_remembered_requests, options.limits.max_remembered_bytes),
        hub(the_host, options.limits.max_subscribers_per_sheet, options.instance_id),
        studio(the_renderer, pictures, the_clock, kStudioThreads),
        drawer(options.limits.max_waiting_pictures),
        filer(options.limits.max_waiting_files),
        analyst(options.limits.max_waiting_analyses) {}

  host::Host& host;
  render::Renderer* const renderer;  // may be null
  const ApiOptions options;
  host::Clock& clock;
  const host::Nanoseconds started_at;
  std::atomic<bool> stopping{false};
  std::atomic<std::int32_t> num_watchers{0};
  std::atomic<std::int64_t> uploading_bytes{0};  // declared by uploads under way
  std::atomic<std::int32_t> recordings_sent{0};  // being made or on their way
  RequestLog requests;
  CutJournal journal;
  std::atomic<std::int32_t> num_image_streams{0};
  PictureCounters pictures;
  StreamHub hub;
  PictureStudio studio;      // of image streams; its threads, too, are
  BackgroundWorker drawer;   // of single pictures; stopped by ~Api, so that it never ends on its own thread
  BackgroundWorker filer;    // of exports and recordings; likewise
  BackgroundWorker analyst;  // of analyses; likewise

  OpenStreams streams;
};

// kUnavailable, for everything after Api::stop().
Error server_stopping();

// kUnavailable RENDERER_UNAVAILABLE, with the reason.
Status check_renderer(const ApiCore& core);

// Api::create_sheet(), which takes the mesh out of the request.
void make_sheet(const std::shared_ptr<ApiCore>& core, v1::CreateSheetRequest request, Reply<v1::Sheet> reply,
                const std::stop_token& stop);

// The sheet id that a request names in `field`, or why it is not served.
Result<std::string> addressed_sheet(const ApiCore& core, const std::string& name, const char* field);

// The host's errors with the request's field in place of none.
Error at_field(Error error, const char* field);

// Of a sheet to be made; empty: none given. kInvalidArgument SHEET_ID.
Status check_sheet_id(const std::string& id);

// kInvalidArgument REQUEST_ID_TOO_LONG.
Status check_request_id(const std::string& request_id);

// Gives the journal what the host's listener receives: cuts, resets, undos and redos that have no caller to answer, and
// scheduled cuts that were refused. The answer to a caller does the same for its own command.
void keep_in_journal(ApiCore& core, const std::string& sheet_id, const sheet::Command& command,
                     const Result<host::CommandResult>& result, const host::Appointment& appointment);

// kerf.v1.Sheet.
v1::Sheet encode_sheet(const host::SheetStatus& status);

// Answers with the sheet as it is then; errors are about `field`.
host::Callback<host::SheetStatus> sheet_reply(Reply<v1::Sheet> reply, const char* field);

// Does `perform` once for each request_id: see RequestLog. `method` keeps the ids of different methods apart. `caller`:
// requests a stop where the caller leaves; what `perform` is given does so where all have left who wait for it.
template <typename Response, typename Request>
void once_while_wanted(const std::shared_ptr<ApiCore>& core, const char* method, const Request& request,
                       Reply<Response> reply, const std::stop_token& caller,
                       const std::function<void(Reply<Response>, const std::stop_token&)>& perform) {
  if (request.request_id().empty()) return perform(std::move(reply), caller);
  if (const Status status = check_request_id(request.request_id()); !status.ok()) return reply(status.error());
  const std::string key = std::string(method) + ' ' + request.request_id();
  const auto repeat = [reply](const RequestLog::Outcome& known) {
    if (!known.ok()) return reply(known.error());
    Response response;
    response.ParseFromString(*known);
    reply(std::move(response));
  };
  const std::optional<std::stop_token> all_left =
      core->requests.begin(key, request.SerializeAsString(), repeat, caller);
  if (!all_left) return;
  const auto finish = [core, key, reply](Result<Response> result) {
    core->requests.finish(
        key, result.ok() ? RequestLog::Outcome(result->SerializeAsString()) : RequestLog::Outcome(result.error()));
    reply(std::move(result));
  };
  perform(finish, *all_left);
}

// The same of what is done whether or not somebody waits for it.
template <typename Response, typename Request>
void once(const std::shared_ptr<ApiCore>& core, const char* method, const Request& request, Reply<Response> reply,
          const std::function<void(Reply<Response>)>& perform) {
  once_while_wanted<Response>(
      core, method, request, std::move(reply), {},
      [&](Reply<Response> answer, const std::stop_token& /*never*/) { perform(std::move(answer)); });
}

// Runs `work` on a background worker and replies with what it makes, with what comes out of it (see caught()), or why
// it is not run. `full`: what to reply where too much waits.
template <typename Made>
void in_background(BackgroundWorker& worker, const Reply<Made>& reply, std::function<Result<Made>()> work,
                   const Error& full) {
  switch (
      worker.submit([reply, work = std::move(work)] { reply(caught(work)); }, [reply] { reply(server_stopping()); })) {
    case BackgroundWorker::Outcome::kTaken:
      return;
    case BackgroundWorker::Outcome::kStopped:
      return reply(server_stopping());
    case BackgroundWorker::Outcome::kFull:
      return reply(full);
  }
}

// kResourceExhausted: as many pictures and files, or analyses, are waiting as may.
Error too_many_pictures(const ApiCore& core);
Error too_many_files(const ApiCore& core);
Error too_many_analyses(const ApiCore& core);

// Copies a sheet between two ticks. RESOURCE_EXHAUSTED SHEET_TOO_LARGE beyond the vertices that are analysed.
void copy_sheet(const std::shared_ptr<ApiCore>& core, const std::string& sheet_id, const char* field,
                std::function<void(Result<std::shared_ptr<sheet::Sheet>>)> done);

// Looks at a sheet between two ticks and hands on what `look` found, or what came out of it, see caught().
template <typename Found>
void look_at(const std::shared_ptr<ApiCore>& core, const std::string& sheet_id,
             std::function<Found(const sheet::Sheet&)> look, const char* field,
             std::function<void(Result<Found>)> done) {
  auto found = std::make_shared<std::optional<Result<Found>>>();
  core->host.inspect(
      sheet_id,
      [found, look = std::move(look)](const sheet::Sheet& sheet) {
        found->emplace(caught([&] { return Result<Found>(look(sheet)); }));
      },
      [found, field, done = std::move(done)](const Status& status) {
        if (!status.ok()) return done(at_field(status.error(), field));
        done(std::move(**found));
      });
}

}  // namespace kerf::api
