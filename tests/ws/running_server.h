#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "server/app/config.h"
#include "server/app/server.h"

// A whole kerfd in the test's process.
namespace kerf::ws_test {

// Free ports, no pictures.
inline app::Config test_config() {
  app::Config config;
  config.grpc = {"127.0.0.1", 0};
  config.http = {"127.0.0.1", 0};
  config.workers = 2;
  config.render = false;
  config.max_load = 0.0;  // a machine that is busy with other things refuses no test its sheets
  return config;
}

inline std::unique_ptr<app::Server> start_server(const app::Config& config = test_config()) {
  Result<std::unique_ptr<app::Server>> server = app::Server::start(config, [](std::string_view) {});
  EXPECT_TRUE(server.ok()) << server.error().message;
  return server.ok() ? std::move(server).value() : nullptr;
}

// The number after the last colon.
inline int port_of(const std::string& address) {
  return std::atoi(address.substr(address.rfind(':') + 1).c_str());
}

}  // namespace kerf::ws_test
