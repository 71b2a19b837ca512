#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "client/cpp/client.h"
#include "tests/ws/running_server.h"

// A whole kerfd, called over gRPC.
namespace kerf::rpc_test {

class RpcServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    server_ = ws_test::start_server();
    ASSERT_NE(server_, nullptr);
    client_ = std::make_unique<client::Client>(server_->grpc_address());
  }
  v1::Sheet create(const std::string& id) {
    v1::CreateSheetRequest request;
    request.set_sheet_id(id);
    request.set_paused(true);
    v1::GridMesh& grid = *request.mutable_scene()->mutable_grid();
    grid.set_columns(8);
    grid.set_rows(8);
    grid.set_width_m(1.0);
    grid.set_height_m(1.0);
    v1::Sheet sheet;
    const grpc::Status status = client_->call(&v1::SheetService::Stub::CreateSheet, client_->sheets(), request, sheet);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return sheet;
  }
  v1::Sheet get(const std::string& name) {
    v1::GetSheetRequest request;
    request.set_name(name);
    v1::Sheet sheet;
    EXPECT_TRUE(client_->call(&v1::SheetService::Stub::GetSheet, client_->sheets(), request, sheet).ok());
    return sheet;
  }
  std::unique_ptr<app::Server> server_;
  std::unique_ptr<client::Client> client_;
};

}  // namespace kerf::rpc_test
