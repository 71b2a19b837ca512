#include "client/cpp/transfers.h"

#include <chrono>
#include <memory>
#include <utility>

#include <grpcpp/support/sync_stream.h>

namespace kerf::client {
namespace {

// Largest mesh file sent in the request, which may have 1 MiB; larger ones are sent in parts.
constexpr std::size_t kMaxEmbeddedBytes = std::size_t{512} << 10;

// Sends `start`, then the file in chunks. A server that refuses the file ends the call early, with the reason in its
// status.
template <typename Message>
grpc::Status send(grpc::ClientWriter<Message>& writer, const Message& start, std::string_view file) {
  bool open = writer.Write(start);
  for (std::size_t at = 0; open && at < file.size(); at += kUploadChunkBytes) {
    Message message;
    message.set_chunk(std::string(file.substr(at, kUploadChunkBytes)));
    open = writer.Write(message);
  }
  writer.WritesDone();
  return writer.Finish();
}

void set_timeout(grpc::ClientContext& context, std::chrono::milliseconds timeout) {
  context.set_deadline(std::chrono::system_clock::now() + timeout);
}

// Removes the mesh file from the scene and returns it if it is too large for a message; otherwise returns an empty
// text.
std::string take_large_mesh(v1::Scene& scene) {
  std::string* file = nullptr;
  if (scene.has_obj()) file = scene.mutable_obj()->mutable_text();
  if (scene.has_ply()) file = scene.mutable_ply()->mutable_data();
  return file != nullptr && file->size() > kMaxEmbeddedBytes ? std::exchange(*file, {}) : std::string();
}

}  // namespace

grpc::Status create_sheet(Client& client, v1::CreateSheetRequest request, v1::Sheet& sheet,
                          std::chrono::milliseconds timeout) {
  const std::string mesh_file = take_large_mesh(*request.mutable_scene());
  if (!mesh_file.empty()) return upload_sheet(client, request, mesh_file, sheet, timeout);
  return client.call(&v1::SheetService::Stub::CreateSheet, client.sheets(), request, sheet, timeout);
}

grpc::Status upload_sheet(Client& client, const v1::CreateSheetRequest& request, std::string_view mesh_file,
                          v1::Sheet& sheet, std::chrono::milliseconds timeout) {
  v1::UploadSheetRequest start;
  *start.mutable_start()->mutable_sheet() = request;
  start.mutable_start()->set_num_bytes(static_cast<std::int64_t>(mesh_file.size()));
  grpc::ClientContext context;
  set_timeout(context, timeout);
  const std::unique_ptr<grpc::ClientWriter<v1::UploadSheetRequest>> writer =
      client.sheets().UploadSheet(&context, &sheet);
  return send(*writer, start, mesh_file);
}

grpc::Status replay_recording(Client& client, const std::string& sheet_id, bool paused, std::string_view recording,
                              v1::Sheet& sheet, std::chrono::milliseconds timeout) {
  v1::ReplayRecordingRequest start;
  start.mutable_start()->set_sheet_id(sheet_id);
  start.mutable_start()->set_paused(paused);
  start.mutable_start()->set_num_bytes(static_cast<std::int64_t>(recording.size()));
  grpc::ClientContext context;
  set_timeout(context, timeout);
  const std::unique_ptr<grpc::ClientWriter<v1::ReplayRecordingRequest>> writer =
      client.sheets().ReplayRecording(&context, &sheet);
  return send(*writer, start, recording);
}

grpc::Status fetch_recording(Client& client, const std::string& name, std::string& recording,
                             std::chrono::milliseconds timeout) {
  v1::GetSheetRecordingRequest request;
  request.set_name(name);
  grpc::ClientContext context;
  set_timeout(context, timeout);
  const std::unique_ptr<grpc::ClientReader<v1::RecordingChunk>> reader =
      client.sheets().GetSheetRecording(&context, request);
  recording.clear();
  v1::RecordingChunk chunk;
  while (reader->Read(&chunk)) recording += chunk.content();
  return reader->Finish();
}

}  // namespace kerf::client
