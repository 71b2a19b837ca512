#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "tests/support/temporary_folder.h"
#include "tests/ws/raw_client.h"
#include "tests/ws/running_server.h"

// A whole kerfd with a viewer, asked over HTTP.
namespace kerf::ws_test {

namespace fs = std::filesystem;

inline constexpr const char* kSheet =
    R"({"sheet_id":"a","paused":true,"scene":{"grid":{"columns":6,"rows":6,"width_m":1,"height_m":1}}})";

// Writes what stands for the built viewer; its folder.
inline fs::path write_viewer(const test::TemporaryFolder& folder) {
  folder.write("viewer/assets/app-12.js", "let viewer;");
  return folder.write("viewer/index.html", "<p>viewer</p>").parent_path();
}

class HttpServerTest : public ::testing::Test {
 protected:
  void start(app::Config config = test_config()) {
    config.web = viewer_;
    server_ = start_server(config);
    ASSERT_NE(server_, nullptr);
    port_ = port_of(server_->http_url());
  }
  void TearDown() override { server_.reset(); }
  [[nodiscard]] Response get(std::string_view target, std::string_view headers = {}) const {
    return request(port_, "GET", target, headers);
  }
  [[nodiscard]] Response call(const std::string& method, std::string_view json, std::string_view headers = {}) const {
    return request(port_, "POST", "/kerf.v1." + method, headers, json);
  }
  [[nodiscard]] double metric(const std::string& name) const {
    const std::string page = get("/metrics").body;
    const std::size_t found = page.find("\n" + name + " ");
    return found == std::string::npos ? -1.0 : std::stod(page.substr(found + name.size() + 2));
  }

  const test::TemporaryFolder folder_;
  const fs::path viewer_ = write_viewer(folder_);
  std::unique_ptr<app::Server> server_;
  int port_ = 0;
};

}  // namespace kerf::ws_test
