#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/base/result.h"
#include "server/service/auth/grant.h"

namespace kerf::auth {
class Authenticator;
}  // namespace kerf::auth
namespace kerf::host {
class Clock;
class Host;
struct StoredRequest;
}  // namespace kerf::host
namespace kerf::render {
class Renderer;
}  // namespace kerf::render
namespace google::protobuf {
class Empty;
class Message;
}  // namespace google::protobuf

namespace kerf::v1 {
class Access;
class AccessLink;
class AnalyzeSheetRequest;
class AnalyzeSheetResponse;
class BackupStoreRequest;
class CancelScheduledCutsRequest;
class CreateCutRequest;
class CreateCutsRequest;
class CreateCutsResponse;
class CreateLinkRequest;
class CreateSheetRequest;
class CutResult;
class DeleteSheetRequest;
class DeleteSetAsideSheetRequest;
class DeleteStateRequest;
class DragPointRequest;
class DrawingReport;
class ExportSheetRequest;
class ExportSheetResponse;
class GetAccessRequest;
class GetServerInfoRequest;
class GetSheetRecordingRequest;
class GetSheetRequest;
class GetSheetStateRequest;
class GetStoreInfoRequest;
class GrabPointRequest;
class InspectDrawingRequest;
class InspectMeshRequest;
class InteractionResponse;
class ListCutsRequest;
class ListCutsResponse;
class ListPiecesRequest;
class ListPiecesResponse;
class ListSheetsRequest;
class ListSheetsResponse;
class ListStatesRequest;
class ListStatesResponse;
class MeshReport;
class PauseSheetRequest;
class PruneStoreRequest;
class PruneStoreResponse;
class RecordingUpload;
class RedoCutRequest;
class ReleasePointRequest;
class RenderImageRequest;
class RenderImageResponse;
class ResetSheetRequest;
class RestoreStateRequest;
class ResumeSheetRequest;
class SaveStateRequest;
class SavedState;
class ScheduledCuts;
class ServerInfo;
class SetSheetGravityRequest;
class SetSheetMaterialRequest;
class SetSheetPinsRequest;
class SetSheetSelfContactRequest;
class SetSheetSpeedRequest;
class SetSheetWindRequest;
class Sheet;
class SheetState;
class SheetUpload;
class StepSheetRequest;
class StepSheetsRequest;
class StepSheetsResponse;
class StoreBackup;
class StoreInfo;
class SubscribeRequest;
class UndoCutRequest;
class UndoResult;
class WatchImagesStart;
}  // namespace kerf::v1

// Implements the RPCs once for all transports. A transport decodes these messages, calls the method with the name of
// the RPC, and encodes the answer. This layer depends on neither gRPC nor HTTP.
namespace kerf::api {

class AuditLog;
class ImageSession;
class KeptStore;
class Tenants;
class Upload;
class UploadRoom;
class WatchSession;
struct ApiCore;

// Called exactly once: on the caller's thread if a request is refused at once, else on a thread of the host or of a
// background worker. It must not block; it may call the Api again.
template <typename T>
using Reply = std::function<void(Result<T>)>;

struct Limits {
  std::int32_t max_request_bytes = 1 << 20;                // One request message; enforced by the transports.
  std::int32_t max_subscribers_per_sheet = 256;            // Streams watching one sheet.
  std::int32_t max_unsent_bytes_per_subscriber = 4 << 20;  // Frames of one stream sent and not acknowledged.
  std::chrono::milliseconds watch_ack_timeout{10'000};     // A stream that owes an acknowledgement for longer is ended.
  std::size_t max_remembered_requests = 4096;              // request_ids; the oldest are forgotten first.
  std::size_t max_remembered_bytes = std::size_t{16} << 20;  // Bytes of remembered request_ids and answers.
  std::size_t max_waiting_analyses = 8;                      // AnalyzeSheet calls waiting behind the one in progress.
  std::int32_t max_analyzed_vertices = 100'000;              // Vertices of a sheet that is analysed.
  std::int32_t max_image_streams = 64;                       // WatchImages and MJPEG streams of all sheets together.
  std::size_t max_waiting_pictures = 16;                     // RenderImage calls waiting behind the one in progress.
  // ExportSheet calls and recordings, up and down, waiting behind the one in progress.
  std::size_t max_waiting_files = 16;
  std::size_t max_waiting_store_calls = 16;                           // Calls of StoreService waiting behind others.
  std::int64_t max_mesh_upload_bytes = std::int64_t{64} << 20;        // Mesh file of UploadSheet.
  std::int64_t max_recording_upload_bytes = std::int64_t{128} << 20;  // File of ReplayRecording.
  std::int64_t max_recorded_ticks = std::int64_t{4} << 20;     // Entries of that file: 19 h at 60 Hz with one per tick.
  std::int64_t max_recorded_parts = std::int64_t{1} << 20;     // Parts of that file, see wire::RecordingLimits.
  std::int64_t max_stepped_bytes = std::int64_t{64} << 20;     // States in one answer of StepSheets.
  std::int32_t max_recordings_sent = 16;                       // Sent to clients at once, each a whole file in memory.
  std::int64_t max_uploading_bytes = std::int64_t{256} << 20;  // Bytes of all uploads in progress.

  // Returns the time after which a stream is cut off if a message was not taken. The margin beyond watch_ack_timeout
  // lets a reader that stalls and recovers still read that it was too slow.
  [[nodiscard]] std::chrono::milliseconds stream_write_timeout() const { return watch_ack_timeout * 13 / 10; }
};

struct ApiOptions {
  std::string version = "0.0.0";  // Reported by GetServerInfo.
  std::string instance_id;        // Reported by GetServerInfo; different at each start of the server.
  Limits limits;
  KeptStore* store = nullptr;                    // Outlives the Api. nullptr: the server keeps nothing.
  auth::Authenticator* authenticator = nullptr;  // Outlives the Api. nullptr: everybody may do everything.
  Tenants* tenants = nullptr;                    // Outlives the Api and its streams. nullptr: there are none.
  // All callers come through a proxy on this machine, which says for each whom it speaks for.
  bool is_behind_proxy = false;
  AuditLog* audit = nullptr;  // Outlives the Api and its streams. nullptr: there is none.
};

// Counts the work done for streams of frames so far.
struct FrameCounts {
  std::int64_t encoded = 0;  // Keyframes and deltas; one frame shared by several viewers counts once.
  std::int64_t sent = 0;
};

// Counts the work done for pictures so far, in streams and RenderImage.
struct PictureCounts {
  std::int64_t rendered = 0;
  std::int64_t encoded = 0;
  std::int64_t shared = 0;   // Given to a stream, but encoded for another stream or for an earlier picture.
  std::int64_t sent = 0;     // Sent to streams.
  std::int64_t skipped = 0;  // Ticks not shown to streams between their pictures, summed over streams.
  std::int32_t streams = 0;  // Open now.
};

// Names the form in which a caller sends and gets messages: JSON (snake_case names, defaults printed), or the bytes of
// Protocol Buffers.
enum class Encoding { kJson, kBinary };

// Describes a unary method for a transport that has the RPC's messages in one of the forms.
struct Method {
  std::string path;  // "/kerf.v1.CutService/CreateCut"
  // Calls it. The reply has the form of the request. Errors: those of the RPC, of Api::allow(), of wire::from_json()
  // and wire::check_finite(); kInvalidArgument MALFORMED_MESSAGE. `stop` is triggered when no caller waits for the
  // reply any more. A long method may then end early; it still replies.
  std::function<void(std::string_view request, Encoding encoding, const auth::Caller& caller, Reply<std::string> reply,
                     std::stop_token stop)>
      call;
};

// Records what becomes of a request; null: it need not be recorded. `sheet`: id of the sheet if the request names none.
using Recorder = std::function<void(const Status& outcome, const std::string& sheet)>;

// Answers the requests of one server. Callable from any thread. Its methods do what they are asked to: a transport
// calls allow() before, for the caller that caller_of() or a login gives, and passes a reply of recorded(). The
// methods() and streams do so by themselves. `host`, `clock` and `renderer` must outlive it and every session made by
// it. The proto files list the errors of each RPC. An unknown sheet is kNotFound SHEET_NOT_FOUND with field "name" or
// "parent", a malformed name is kInvalidArgument, and after stop() every call gets kUnavailable.
class Api {
 public:
  // Becomes the host's command listener, so it must be made before any sheet runs. `renderer` may be null or the null
  // renderer: RenderImage is then refused with kUnavailable.
  Api(host::Host& host, render::Renderer* renderer, ApiOptions options, host::Clock& clock);
  ~Api();  // stop(), and waits for pictures being drawn
  Api(const Api&) = delete;
  Api& operator=(const Api&) = delete;

  // Returns who sent `authorization`, the value of that header or metadata: everybody if the server asks for no tokens.
  // `address`: see address_of(). Errors: those of auth::Authenticator::find_bearer().
  [[nodiscard]] Result<auth::Caller> caller_of(std::string_view authorization, std::string address) const;
  // Returns the address of a caller: that of the peer, or behind a proxy the one that it gives as `x-forwarded-for`.
  [[nodiscard]] std::string address_of(std::string peer, std::string_view forwarded_for) const;
  // Decides whether a caller may send a request, see check_access(), and counts it for the caller's tenant. Errors:
  // those; kResourceExhausted TENANT_CUTS, TENANT_VERTICES. A refusal is recorded, if the request would be.
  [[nodiscard]] Status allow(const auth::Caller& caller, const google::protobuf::Message& request) const;
  // Returns what records the outcome of a request that was allowed.
  [[nodiscard]] Recorder recorder(const auth::Caller& caller, const google::protobuf::Message& request) const;
  // Returns a reply that also records the outcome, if that is needed.
  template <typename T>
  [[nodiscard]] Reply<T> recorded(const auth::Caller& caller, const google::protobuf::Message& request,
                                  Reply<T> reply) const;
  // Records a login, or its end, or a token that was refused.
  void record(const auth::Caller& caller, const std::string& call, const Status& outcome) const;
  [[nodiscard]] auth::Authenticator* authenticator() const;  // As in ApiOptions.
  // Says what a caller may do.
  [[nodiscard]] v1::Access describe(const auth::Caller& caller) const;
  // Ends the streams of callers whose grants were withdrawn. To be called after that.
  void check_callers();

  // Remembers requests of the server before, newest first, so that one sent again gets its answer.
  void remember(std::vector<host::StoredRequest> requests);

  // `stop` is triggered when the client leaves; the sheet is then not made.
  void create_sheet(const v1::CreateSheetRequest& request, Reply<v1::Sheet> reply, std::stop_token stop = {});
  void get_sheet(const v1::GetSheetRequest& request, Reply<v1::Sheet> reply);
  // Lists the sheets that the caller reaches.
  void list_sheets(const v1::ListSheetsRequest& request, const auth::Caller& caller,
                   Reply<v1::ListSheetsResponse> reply);
  void delete_sheet(const v1::DeleteSheetRequest& request, Reply<google::protobuf::Empty> reply);
  void pause_sheet(const v1::PauseSheetRequest& request, Reply<v1::Sheet> reply);
  void resume_sheet(const v1::ResumeSheetRequest& request, Reply<v1::Sheet> reply);
  // Ends early after a tick, with the result so far, once `stop` is triggered: no caller waits for the answer then.
  void step_sheet(const v1::StepSheetRequest& request, Reply<v1::Sheet> reply, std::stop_token stop);
  void step_sheets(const v1::StepSheetsRequest& request, Reply<v1::StepSheetsResponse> reply, std::stop_token stop);
  void set_sheet_speed(const v1::SetSheetSpeedRequest& request, Reply<v1::Sheet> reply);
  void reset_sheet(const v1::ResetSheetRequest& request, Reply<v1::Sheet> reply);
  void export_sheet(const v1::ExportSheetRequest& request, Reply<v1::ExportSheetResponse> reply);
  void get_sheet_state(const v1::GetSheetStateRequest& request, Reply<v1::SheetState> reply);
  void save_state(const v1::SaveStateRequest& request, Reply<v1::SavedState> reply);
  void restore_state(const v1::RestoreStateRequest& request, Reply<v1::Sheet> reply);
  void list_states(const v1::ListStatesRequest& request, Reply<v1::ListStatesResponse> reply);
  void delete_state(const v1::DeleteStateRequest& request, Reply<google::protobuf::Empty> reply);
  // Begin SheetService.UploadSheet and ReplayRecording; the transport then passes the bytes to the upload. Refused
  // before the first byte: kInvalidArgument with the field below `start`, kResourceExhausted TOO_MANY_UPLOADS.
  Result<std::unique_ptr<Upload>> upload_sheet(const v1::SheetUpload& start);
  Result<std::unique_ptr<Upload>> replay_recording(const v1::RecordingUpload& start);
  // Reserves room among all uploads, for a transport that must read the whole file before it can begin its upload. The
  // room is kept until the result is destroyed. An upload takes room of its own, so destroy the result before it
  // begins. kResourceExhausted TOO_MANY_UPLOADS.
  Result<std::shared_ptr<const UploadRoom>> reserve_upload(std::int64_t num_bytes);
  // Returns the whole file of SheetService.GetSheetRecording. It counts as being sent until the reply's value is
  // destroyed. kResourceExhausted TOO_MANY_RECORDINGS.
  void get_sheet_recording(const v1::GetSheetRecordingRequest& request,
                           Reply<std::shared_ptr<const std::string>> reply);
  // Ends early after an iteration, with the result so far, once `stop` is triggered.
  void analyze_sheet(const v1::AnalyzeSheetRequest& request, Reply<v1::AnalyzeSheetResponse> reply,
                     std::stop_token stop);

  // Ends early once `stop` is triggered.
  void inspect_mesh(const v1::InspectMeshRequest& request, Reply<v1::MeshReport> reply, std::stop_token stop);
  // The same without a copy of the file.
  void inspect_mesh(v1::InspectMeshRequest&& request, Reply<v1::MeshReport> reply, std::stop_token stop);

  void create_cut(const v1::CreateCutRequest& request, Reply<v1::CutResult> reply);
  void create_cuts(const v1::CreateCutsRequest& request, Reply<v1::CreateCutsResponse> reply);
  void list_cuts(const v1::ListCutsRequest& request, Reply<v1::ListCutsResponse> reply);
  void cancel_scheduled_cuts(const v1::CancelScheduledCutsRequest& request, Reply<v1::ScheduledCuts> reply);
  void undo_cut(const v1::UndoCutRequest& request, Reply<v1::UndoResult> reply);
  void redo_cut(const v1::RedoCutRequest& request, Reply<v1::UndoResult> reply);
  void list_pieces(const v1::ListPiecesRequest& request, Reply<v1::ListPiecesResponse> reply);

  void grab_point(const v1::GrabPointRequest& request, Reply<v1::InteractionResponse> reply);
  void drag_point(const v1::DragPointRequest& request, Reply<v1::InteractionResponse> reply);
  void release_point(const v1::ReleasePointRequest& request, Reply<v1::InteractionResponse> reply);
  void set_sheet_pins(const v1::SetSheetPinsRequest& request, Reply<v1::InteractionResponse> reply);
  void set_sheet_gravity(const v1::SetSheetGravityRequest& request, Reply<v1::InteractionResponse> reply);
  void set_sheet_wind(const v1::SetSheetWindRequest& request, Reply<v1::InteractionResponse> reply);
  void set_sheet_material(const v1::SetSheetMaterialRequest& request, Reply<v1::InteractionResponse> reply);
  void set_sheet_self_contact(const v1::SetSheetSelfContactRequest& request, Reply<v1::InteractionResponse> reply);

  void render_image(const v1::RenderImageRequest& request, Reply<v1::RenderImageResponse> reply);
  // FileService. It reads nothing of the server.
  void inspect_drawing(const v1::InspectDrawingRequest& request, Reply<v1::DrawingReport> reply);
  void get_server_info(const v1::GetServerInfoRequest& request, Reply<v1::ServerInfo> reply);

  // Without ApiOptions::store these are kFailedPrecondition NO_STORE.
  void get_store_info(const v1::GetStoreInfoRequest& request, Reply<v1::StoreInfo> reply);
  void prune_store(const v1::PruneStoreRequest& request, Reply<v1::PruneStoreResponse> reply);
  void delete_set_aside_sheet(const v1::DeleteSetAsideSheetRequest& request, Reply<google::protobuf::Empty> reply);
  // It is made even if its caller leaves; stop() gives it up. One at a time: kResourceExhausted BACKUP_UNDER_WAY.
  void backup_store(const v1::BackupStoreRequest& request, Reply<v1::StoreBackup> reply);

  void get_access(const v1::GetAccessRequest& request, const auth::Caller& caller, Reply<v1::Access> reply);
  void create_link(const v1::CreateLinkRequest& request, const auth::Caller& caller, Reply<v1::AccessLink> reply);

  // Streams check each request of theirs. They fail at once if `caller` is an error, and end once the caller is no
  // longer granted what it does. Returns a new stream of StreamService.Watch.
  std::shared_ptr<WatchSession> watch(const Result<auth::Caller>& caller = auth::everybody());
  // Returns a started session of StreamService.Subscribe, which takes no requests.
  std::shared_ptr<WatchSession> subscribe(const v1::SubscribeRequest& request,
                                          const Result<auth::Caller>& caller = auth::everybody());

  // Returns a new stream of RenderService.WatchImages.
  std::shared_ptr<ImageSession> watch_images(const Result<auth::Caller>& caller = auth::everybody());
  // Returns a started stream of pictures that takes no requests. Pictures count as acknowledged once they are sent: for
  // a transport that notices by itself how fast its reader is.
  std::shared_ptr<ImageSession> play_images(const v1::WatchImagesStart& start,
                                            const Result<auth::Caller>& caller = auth::everybody());

  // Returns every unary method above, ordered by path. Lives as long as the Api.
  [[nodiscard]] const std::vector<Method>& methods() const;

  // Returns the number of open streams.
  [[nodiscard]] std::int32_t num_watchers() const;
  // Counts the frames of all streams since the start.
  [[nodiscard]] FrameCounts frame_counts() const;
  [[nodiscard]] PictureCounts picture_counts() const;
  [[nodiscard]] const Limits& limits() const;

  // Ends every stream with SERVER_STOPPING, and refuses waiting pictures and all later requests. Idempotent. The host
  // still answers requests that it has accepted, so stop the host next.
  void stop();

 private:
  std::shared_ptr<ApiCore> core_;  // Shared with replies and streams still in progress.
  std::vector<Method> methods_;
};

// Returns the id in the name of a sheet.
std::string id_of(const v1::Sheet& sheet);
// Return NO_INTERSECTION for cuts that were answered and changed nothing.
Status outcome_of(const v1::CutResult& result);
Status outcome_of(const v1::CreateCutsResponse& result);

template <typename T>
Reply<T> Api::recorded(const auth::Caller& caller, const google::protobuf::Message& request, Reply<T> reply) const {
  Recorder record = recorder(caller, request);
  if (!record) return reply;
  return [record = std::move(record), reply = std::move(reply)](Result<T> result) {
    std::string sheet;
    if constexpr (std::is_same_v<T, v1::Sheet>) {
      if (result.ok()) sheet = id_of(*result);
    }
    Status outcome = result.ok() ? Status(Nothing{}) : Status(result.error());
    if constexpr (std::is_same_v<T, v1::CutResult> || std::is_same_v<T, v1::CreateCutsResponse>) {
      if (result.ok()) outcome = outcome_of(*result);
    }
    record(outcome, sheet);
    reply(std::move(result));
  };
}

}  // namespace kerf::api
