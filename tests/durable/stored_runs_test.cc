#include "server/service/durable/stored_runs.h"

#include <gtest/gtest.h>

#include "server/service/durable/change_codec.h"
#include "server/service/durable/state_codec.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace kerf::durable {
namespace {

// A sheet in a store of its own.
class StoredRuns : public testing::Test {
 protected:
  StoredRuns() {
    store::StoreOptions options;
    options.folder = (folder_ / "store").string();
    options.now = [] { return std::chrono::nanoseconds(0); };
    options.unix_us = [] { return std::int64_t{1}; };
    options.failed = [](const std::string& message) { ADD_FAILURE() << message; };
    options.reserve_bytes = 0;
    store_ = store::SqliteStore::open(std::move(options)).value();
    store_->create({store_->new_sheet_number(), "a", encode_stored_scene(scenes::hanging(5)), 7, {}}, nullptr);
  }
  void append(std::int64_t tick, const host::SheetEvent& event, std::vector<host::StoredRequest> requests = {}) {
    store_->append({1, ++last_, tick, 5, encode_change(event), std::move(requests)}, nullptr);
  }
  void save(std::int64_t tick, const std::string& name = {}) {
    host::SavedState state;
    state.status.id = name;
    state.status.tick = tick;
    state.run.sheet = std::make_shared<const std::string>("the sheet at " + std::to_string(tick));
    state.run.scheduled.push_back({{tick + 9, 3}, scene::UndoCut{}});
    state.run.changes = host::SceneChanges(true, 4, 2);
    state.run.speed = 0.5;
    state.run.attachment = "cuts";
    state.run.stream_grabs = {"hand"};
    store_->save({1, last_, tick, 0, 0, 0, name, encode_state(state), {}}, nullptr);
  }
  Result<host::StoredRun> run() {
    EXPECT_TRUE(store_->wait_until_durable().ok());
    return read_run(*store_, store_->sheets()->at(0));
  }

  test::TemporaryFolder folder_;
  std::unique_ptr<store::SqliteStore> store_;
  std::int64_t last_ = 0;
};

TEST_F(StoredRuns, WithoutAStateHaveAllChanges) {
  append(3, host::RunEvent{true, 1.0});
  append(8, host::TickEvent{{scene::UndoCut{}}, {}, {}, false});
  store_->mark({{1, 40}});
  const host::StoredRun found = run().value();
  EXPECT_EQ(found.id, "a");
  EXPECT_EQ(found.created_unix_us, 7);
  EXPECT_FALSE(found.state);
  ASSERT_EQ(found.changes.size(), 2U);
  EXPECT_EQ(found.changes[1].tick, 8);
  EXPECT_EQ(found.last_seq, 2);
  EXPECT_EQ(found.mark_tick, 40);
}

TEST_F(StoredRuns, BeginWithTheSceneIfAllChangesAreThere) {
  append(3, host::RunEvent{true, 1.0});
  save(5, "mine");
  save(6);
  append(8, host::RunEvent{false, 1.0});
  ASSERT_TRUE(run().ok());
  const host::StoredRun found = read_run(*store_, store_->sheets()->at(0), Beginning::kScene).value();
  EXPECT_FALSE(found.state);
  EXPECT_EQ(found.named.size(), 1U);
  ASSERT_EQ(found.changes.size(), 2U);
  EXPECT_EQ(found.changes[0].tick, 3);
  EXPECT_EQ(found.last_seq, 2);
  EXPECT_EQ(found.mark_tick, 8);
  // Without its changes the sheet must not begin with them missing.
  ASSERT_TRUE(store_->remove_entries_after(1, 0).ok());
  const auto none = read_run(*store_, store_->sheets()->at(0), Beginning::kScene);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().reason, "JOURNAL_DAMAGED");
}

TEST_F(StoredRuns, HaveTheNewestStateTheNamedOnesAndTheChangesAfterIt) {
  append(3, host::RunEvent{true, 1.0});
  save(5, "mine");
  save(6);
  append(8, host::RunEvent{false, 1.0});
  const host::StoredRun found = run().value();
  ASSERT_TRUE(found.state);
  EXPECT_EQ(*found.state->run.sheet, "the sheet at 6");
  EXPECT_EQ(found.state->run.scheduled.at(0).id.number, 3);
  EXPECT_EQ(found.state->run.changes.resets(), 4);
  EXPECT_EQ(found.state->run.attachment, "cuts");
  EXPECT_EQ(found.state->run.stream_grabs, std::vector<std::string>{"hand"});
  ASSERT_EQ(found.named.size(), 1U);
  EXPECT_EQ(found.named[0].status.id, "mine");
  ASSERT_EQ(found.changes.size(), 1U);
  EXPECT_EQ(found.mark_tick, 8);
}

TEST_F(StoredRuns, EndBeforeARestoreWhoseStateIsNotThere) {
  append(3, host::RunEvent{true, 1.0});
  save(3);
  append(1, host::RestoreEvent{}, {{"RestoreState 1", 9, "answer"}});
  append(2, host::RunEvent{false, 1.0});
  const host::StoredRun found = run().value();
  EXPECT_TRUE(found.changes.empty());
  EXPECT_EQ(found.last_seq, 1);
  EXPECT_EQ(found.mark_tick, 3);
  EXPECT_TRUE(store_->requests(9, 999)->requests.empty()) << "a repeat must restore";
  EXPECT_TRUE(store_->entries(1, 1)->empty());
}

TEST_F(StoredRuns, ContinueFromTheStateOfARestore) {
  append(3, host::RunEvent{true, 1.0});
  append(1, host::RestoreEvent{});
  save(1);
  const host::StoredRun found = run().value();
  EXPECT_EQ(found.state->status.tick, 1);
  EXPECT_EQ(found.last_seq, 2);
}

TEST_F(StoredRuns, RefuseAChangeOfAnUnknownKind) {
  store_->append({1, ++last_, 1, 5, "\x7a\x01x", {}}, nullptr);
  EXPECT_EQ(run().error().reason, "CHANGE_DAMAGED");
}

}  // namespace
}  // namespace kerf::durable
