#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include <grpcpp/support/status.h>

#include "client/cpp/client.h"

// Transfers files larger than a message to the server and from it.
namespace kerf::client {

inline constexpr std::size_t kUploadChunkBytes = std::size_t{256} << 10;  // Below the limit of a message, 1 MiB.
inline constexpr std::chrono::minutes kTransferTimeout{10};               // For a whole file.

// Calls CreateSheet, or upload_sheet() if the mesh file would make the request too large for one message.
grpc::Status create_sheet(Client& client, v1::CreateSheetRequest request, v1::Sheet& sheet,
                          std::chrono::milliseconds timeout = kTransferTimeout);

// Creates a sheet whose mesh file is sent in parts. request.scene must have an obj or ply with empty text or data.
grpc::Status upload_sheet(Client& client, const v1::CreateSheetRequest& request, std::string_view mesh_file,
                          v1::Sheet& sheet, std::chrono::milliseconds timeout = kTransferTimeout);

// Creates a sheet that plays the recording. An empty `sheet_id` means the ID in the recording.
grpc::Status replay_recording(Client& client, const std::string& sheet_id, bool paused, std::string_view recording,
                              v1::Sheet& sheet, std::chrono::milliseconds timeout = kTransferTimeout);

// Fetches the recording of the sheet ("sheets/ID") up to now, as a file's bytes.
grpc::Status fetch_recording(Client& client, const std::string& name, std::string& recording,
                             std::chrono::milliseconds timeout = kTransferTimeout);

}  // namespace kerf::client
