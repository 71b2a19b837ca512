#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/app/config.h"
#include "server/base/result.h"

namespace kerf::app {

// Runs all of kerfd in one process: host, renderer, Api and both transports. Tests start it on port 0.
class Server {
 public:
  // Builds all parts, loads the scenes and listens on both ports. Fails with the first error, before any tick. `note`
  // gets lines for the operator, from any thread: no viewer, no renderer, a recording that stopped.
  static Result<std::unique_ptr<Server>> start(const Config& config,
                                               const std::function<void(std::string_view line)>& note);
  ~Server();  // stop()
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::string grpc_address() const;  // "HOST:PORT", with the port that was bound.
  [[nodiscard]] std::string http_url() const;      // "http://HOST:PORT", or "https://HOST:PORT" with TLS.
  // {"grpc":"HOST:PORT","http":"http://HOST:PORT","data":"DIR"}; without "data" if no sheet is kept.
  [[nodiscard]] std::string ready_line() const;

  // Reads the files of tokens and certificates again. Tokens that are gone or changed are withdrawn, and their streams
  // end. Certificates are for new connections of HTTP; gRPC keeps the old ones. If a file is wrong, what it had stays.
  // `note` gets the outcome. Returns false if the server has no such files.
  bool reload();

  // Stops the server: it reports not ready, ends streams with SERVER_STOPPING, answers accepted commands, then closes
  // both transports. Takes at most 8 s. Idempotent.
  void stop();
  // True once stop() has closed every sheet and its recording; the rest loses no data. Callable from any thread.
  [[nodiscard]] bool has_closed_sheets() const;

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::app
