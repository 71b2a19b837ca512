#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "server/app/config.h"
#include "server/base/result.h"

namespace kerf::app {

// Everything kerfd is made of, in one process: host, renderer, Api and both transports. Tests start it on port 0.
class Server {
 public:
  // Builds it all, loads the scenes and listens on both ports. Fails with the first thing that is wrong, before any
  // tick. `note` is told, a line each and from any thread, what the operator should know: no viewer, no renderer, a
  // recording that stopped.
  static Result<std::unique_ptr<Server>> start(const Config& config,
                                               const std::function<void(std::string_view line)>& note);
  ~Server();  // stop()
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::string grpc_address() const;  // "HOST:PORT", with the port that was bound
  [[nodiscard]] std::string http_url() const;      // "http://HOST:PORT"
  // {"grpc":"HOST:PORT","http":"http://HOST:PORT"}
  [[nodiscard]] std::string ready_line() const;

  // In order: not ready any more, streams are ended with SERVER_STOPPING, commands accepted are answered, both
  // transports close. Takes at most 8 s. Idempotent.
  void stop();
  // From any thread: stop() has closed every sheet and its recording. What is left to end keeps nothing.
  [[nodiscard]] bool has_closed_sheets() const;

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::app
