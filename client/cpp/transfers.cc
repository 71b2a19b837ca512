#include "client/cpp/transfers.h"

#include <chrono>
#include <memory>

#include <grpcpp/support/sync_stream.h>

namespace kerf::client {
namespace {

constexpr std::chrono::minutes kTimeout{10};  // of a whole file

// Sends `start`, then the file in chunks. A server that refuses it ends the call early, and its status says why.
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

void set_timeout(grpc::ClientContext& context) {
  context.set_deadline(std::chrono::system_clock::now() + kTimeout);
}

}  // namespace

grpc::Status upload_sheet(Client& client, const v1::CreateSheetRequest& request, std::string_view mesh_file,
                          v1::Sheet& sheet) {
  v1::UploadSheetRequest start;
  *start.mutable_start()->mutable_sheet() = request;
  start.mutable_start()->set_num_bytes(static_cast<std::int64_t>(mesh_file.size()));
  grpc::ClientContext context;
  set_timeout(context);
  const std::unique_ptr<grpc::ClientWriter<v1::UploadSheetRequest>> writer =
      client.sheets().UploadSheet(&context, &sheet);
  return send(*writer, start, mesh_file);
}

grpc::Status replay_recording(Client& client, const std::string& sheet_id, bool paused, std::string_view recording,
                              v1::Sheet& sheet) {
  v1::ReplayRecordingRequest start;
  start.mutable_start()->set_sheet_id(sheet_id);
  start.mutable_start()->set_paused(paused);
  start.mutable_start()->set_num_bytes(static_cast<std::int64_t>(recording.size()));
  grpc::ClientContext context;
  set_timeout(context);
  const std::unique_ptr<grpc::ClientWriter<v1::ReplayRecordingRequest>> writer =
      client.sheets().ReplayRecording(&context, &sheet);
  return send(*writer, start, recording);
}

grpc::Status fetch_recording(Client& client, const std::string& name, std::string& recording) {
  v1::GetSheetRecordingRequest request;
  request.set_name(name);
  grpc::ClientContext context;
  set_timeout(context);
  const std::unique_ptr<grpc::ClientReader<v1::RecordingChunk>> reader =
      client.sheets().GetSheetRecording(&context, request);
  recording.clear();
  v1::RecordingChunk chunk;
  while (reader->Read(&chunk)) recording += chunk.content();
  return reader->Finish();
}

}  // namespace kerf::client
