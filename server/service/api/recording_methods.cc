#include <utility>

#include "server/service/api/core.h"
#include "server/service/api/upload.h"
#include "server/service/wire/mesh_source_codec.h"
#include "server/service/wire/recording_codec.h"

// Implements the methods for recordings and for files larger than a request.
namespace kerf::api {
namespace {

// Begins an upload whose length is within `limit` and within the room of all uploads.
Result<std::unique_ptr<Upload>> begin_upload(Api& api, std::int64_t num_bytes, std::int64_t limit, Upload::Use use) {
  if (num_bytes < 1 || num_bytes > limit) {
    return invalid_argument(
        "OUT_OF_RANGE", "start.num_bytes is " + std::to_string(num_bytes) + "; must be in 1.." + std::to_string(limit),
        "start.num_bytes");
  }
  KERF_TRY_ASSIGN(std::shared_ptr<const UploadRoom> room, api.reserve_upload(num_bytes));
  return std::make_unique<Upload>(std::move(room), num_bytes, std::move(use));
}

void play(const std::shared_ptr<ApiCore>& core, std::string content, const std::string& sheet_id, bool paused,
          const Reply<v1::Sheet>& reply, const std::stop_token& stop) {
  // Reports data loss as an invalid argument: the faulty file is the client's, and no data of this server is lost.
  const auto answer = [reply](Result<v1::Sheet> sheet) {
    if (sheet.ok() || sheet.error().code != ErrorCode::kDataLoss) return reply(std::move(sheet));
    Error error = sheet.error();
    error.code = ErrorCode::kInvalidArgument;
    reply(std::move(error));
  };
  using Decoded = wire::RecordingFile;
  in_background<Decoded>(
      core->file_worker,
      [core, sheet_id, paused, answer, stop](Result<Decoded> decoded) {
        if (!decoded.ok()) return answer(decoded.error());
        core->host.replay(sheet_id, std::move(decoded->recording), paused, sheet_reply(answer, ""), stop);
      },
      [core, file = std::make_shared<const std::string>(std::move(content))] {
        const Limits& limits = core->options.limits;
        return wire::decode_recording(*file, {limits.max_recorded_ticks, limits.max_recorded_parts});
      },
      too_many_files(*core));
}

// Holds a file being sent to a client, and counts it until nothing holds it any more.
class SentRecording {
 public:
  explicit SentRecording(std::shared_ptr<ApiCore> core) : core_(std::move(core)), together_(++core_->recordings_sent) {}
  ~SentRecording() { --core_->recordings_sent; }
  SentRecording(const SentRecording&) = delete;
  SentRecording& operator=(const SentRecording&) = delete;

  [[nodiscard]] std::int32_t counted_together() const { return together_; }

  std::string content;

 private:
  const std::shared_ptr<ApiCore> core_;
  const std::int32_t together_;
};

}  // namespace

Result<std::shared_ptr<const UploadRoom>> Api::reserve_upload(std::int64_t num_bytes) {
  if (core_->stopping) return server_stopping();
  auto room = std::make_shared<const UploadRoom>(core_, num_bytes);
  const std::int64_t all = core_->options.limits.max_uploading_bytes;
  if (room->taken_together() > all) {
    return resource_exhausted("TOO_MANY_UPLOADS", "uploads in progress may have " + std::to_string(all) +
                                                      " bytes together; try again when one has finished");
  }
  return room;
}

Result<std::unique_ptr<Upload>> Api::upload_sheet(const v1::SheetUpload& start) {
  const v1::Scene& scene = start.sheet().scene();
  const bool is_obj = scene.has_obj() && scene.obj().text().empty() && scene.obj().file().empty();
  const bool is_ply = scene.has_ply() && scene.ply().data().empty() && scene.ply().file().empty();
  if (!is_obj && !is_ply) {
    return invalid_argument(
        "UPLOAD_OF_WHAT", "start.sheet.scene must have an obj without text or a ply without data: the chunks supply it",
        "start.sheet.scene");
  }
  Upload::Use use = [core = core_, request = start.sheet(), is_obj](std::string content, Reply<v1::Sheet> reply,
                                                                    const std::stop_token& stop) mutable {
    Result<std::string> unpacked = wire::unpacked_mesh(std::move(content), is_obj ? "OBJ" : "PLY", "start.sheet.scene");
    if (!unpacked.ok()) return reply(unpacked.error());
    content = std::move(unpacked).value();
    if (is_obj) {
      request.mutable_scene()->mutable_obj()->set_text(wire::obj_text(std::move(content)));
    } else {
      request.mutable_scene()->mutable_ply()->set_data(std::move(content));
    }
    make_sheet(core, std::move(request), std::move(reply), stop);
  };
  return begin_upload(*this, start.num_bytes(), core_->options.limits.max_mesh_upload_bytes, std::move(use));
}

Result<std::unique_ptr<Upload>> Api::replay_recording(const v1::RecordingUpload& start) {
  if (const Status valid = check_sheet_id(start.sheet_id()); !valid.ok()) {
    Error error = valid.error();
    error.field = "start." + error.field;
    return error;
  }
  Upload::Use use = [core = core_, id = start.sheet_id(), paused = start.paused()](
                        std::string content, const Reply<v1::Sheet>& reply, const std::stop_token& stop) {
    play(core, std::move(content), id, paused, reply, stop);
  };
  return begin_upload(*this, start.num_bytes(), core_->options.limits.max_recording_upload_bytes, std::move(use));
}

void Api::get_sheet_recording(const v1::GetSheetRecordingRequest& request,
                              Reply<std::shared_ptr<const std::string>> reply) {
  const Result<std::string> id = addressed_sheet(*core_, request.name(), "name");
  if (!id.ok()) return reply(id.error());
  const auto file = std::make_shared<SentRecording>(core_);
  const std::int32_t most = core_->options.limits.max_recordings_sent;
  if (file->counted_together() > most) {
    return reply(resource_exhausted(
        "TOO_MANY_RECORDINGS",
        std::to_string(most) +
            " recordings are already being sent, which is the limit; try again when one has finished"));
  }
  core_->host.recording(*id, [core = core_, file, reply = std::move(reply)](Result<host::KeptRun> run) {
    if (!run.ok()) return reply(with_field(run.error(), "name"));
    auto kept = std::make_shared<const host::KeptRun>(std::move(*run));
    in_background<std::shared_ptr<const std::string>>(
        core->file_worker, reply,
        [kept, file] {
          file->content = wire::encode_recording_header(*kept->config, wire::build_name()) + kept->entries;
          return std::shared_ptr<const std::string>(file, &file->content);
        },
        too_many_files(*core));
  });
}

}  // namespace kerf::api
