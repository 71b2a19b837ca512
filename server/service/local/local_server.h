#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/base/result.h"

// A server for the process that has it: sheets with their clocks and the calls of proto/kerf/v1, without a network.
namespace kerf::local {

struct LocalOptions {
  std::int32_t workers = 0;  // Threads that step sheets, 1..256; 0: one for each processor.
  bool render = false;       // Draws pictures for RenderImage, where the machine can.
};

// Holds up to 4,096 sheets and answers unary calls. It asks for no tokens, keeps nothing, and refuses no sheet for its
// load.
// Callable from any thread.
class LocalServer {
 public:
  // kInvalidArgument BAD_WORKERS.
  static Result<std::unique_ptr<LocalServer>> start(const LocalOptions& options);
  ~LocalServer();  // Ends all sheets. No call may be in progress.
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;

  // Calls a unary RPC, such as "/kerf.v1.SheetService/StepSheets", with the bytes of its request, and returns those of
  // its response. Returns nothing once `time_limit` is over: a step then ends after its tick in progress, a cut may
  // still be made. Errors: those of the RPC; kNotFound NO_SUCH_CALL.
  std::optional<Result<std::string>> call(std::string_view path, std::string_view request,
                                          std::optional<std::chrono::nanoseconds> time_limit);
  // Makes a sheet as SheetService.UploadSheet does. `start`: bytes of its kerf.v1.SheetUpload. Returns the bytes of a
  // kerf.v1.Sheet, or nothing as call() does: no sheet is made then.
  std::optional<Result<std::string>> upload_sheet(std::string_view start, std::string file,
                                                  std::optional<std::chrono::nanoseconds> time_limit);

 private:
  struct Impl;
  explicit LocalServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::local
