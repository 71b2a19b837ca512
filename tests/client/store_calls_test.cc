// The store of a server, by the methods of client::Server.

#include <filesystem>

#include <gtest/gtest.h>

#include "client/cpp/server.h"
#include "tests/support/temporary_folder.h"
#include "tests/ws/running_server.h"

namespace kerf::client {
namespace {

TEST(StoreCalls, CountPruneAndCopyWhatIsKept) {
  const test::TemporaryFolder folder;
  app::Config config = ws_test::test_config();
  config.data_dir = folder / "data";
  const auto running = ws_test::start_server(config);
  ASSERT_NE(running, nullptr);
  Server server(running->grpc_address());
  ASSERT_TRUE(server.create(grid_scene(4, 4, 1.0, 1.0), {"kept", true, "a request"}).ok());
  const v1::StoreInfo info = server.store_info().value();
  EXPECT_EQ(info.folder(), (folder / "data").string());
  EXPECT_EQ(info.sheets(), 1);
  EXPECT_EQ(info.answers(), 1);
  EXPECT_EQ(server.prune_store().value().removed_answers(), 0);
  EXPECT_EQ(server.delete_set_aside(1).failure().reason, "SET_ASIDE_NOT_FOUND") << "it is not damaged";
  const v1::StoreBackup made = server.backup_store("monday").value();
  EXPECT_EQ(made.folder(), (folder / "data/backups/monday").string());
  EXPECT_TRUE(std::filesystem::exists(folder / "data/backups/monday/kerf.db"));
  EXPECT_EQ(server.backup_store("monday").failure().reason, "BACKUP_EXISTS");
  EXPECT_EQ(server.backup_store("Monday").failure().field, "backup_id");
}

TEST(StoreCalls, AreRefusedByAServerThatKeepsNothing) {
  const auto running = ws_test::start_server();
  ASSERT_NE(running, nullptr);
  Server server(running->grpc_address());
  EXPECT_EQ(server.store_info().failure().reason, "NO_STORE");
  EXPECT_EQ(server.prune_store().failure().reason, "NO_STORE");
  EXPECT_EQ(server.delete_set_aside(1).failure().reason, "NO_STORE");
  EXPECT_EQ(server.backup_store("a").failure().code, grpc::StatusCode::FAILED_PRECONDITION);
}

}  // namespace
}  // namespace kerf::client
