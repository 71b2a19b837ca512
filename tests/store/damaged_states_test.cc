// States that are damaged are set aside: nothing fails for them any more, and their files stay.

#include "server/service/store/damaged_states.h"

#include "tests/store/fixture.h"

namespace kerf::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class DamagedStates : public testing::Test {
 protected:
  void SetUp() override {
    const auto store = on_.open();
    for (int i = 0; i < 2; ++i) store->create(new_sheet(store->new_sheet_number()), nullptr);
    store->save(state(1, 0, "zero"), nullptr);
    store->save(state(1, 0, "mine", "before"), nullptr);
    store->save(state(2, 0, "other"), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
  }
  void set_content(const std::string& path, const std::string& content) {
    auto contents = on_.disk.contents();
    contents[path] = content;
    on_.disk.set_contents(contents);
  }
  void change(const std::string& sql) {
    auto database = store::Database::open("/store/kerf.db", on_.options().vfs);
    ASSERT_TRUE(database->execute("PRAGMA locking_mode = EXCLUSIVE").ok());
    ASSERT_TRUE(database->execute(sql).ok()) << database->error(0, "").message;
  }
  // Expects that the store is whole, and that the other states are there.
  void expect_rest(store::SqliteStore& store) {
    EXPECT_THAT(store.set_damaged_states_aside(1).value(), IsEmpty()) << "once is enough";
    EXPECT_THAT(store.set_damaged_states_aside(2).value(), IsEmpty());
    EXPECT_EQ(store.read_state(1, 0)->content, "zero");
    EXPECT_EQ(store.read_state(2, 0)->content, "other");
    EXPECT_TRUE(store.backup("/copy").ok());
  }

  StoreOnLossyDisk on_;
};

TEST_F(DamagedStates, OfAFileThatHasChanged) {
  set_content("/store/states/1-0-2.state", "MINE");
  const auto store = on_.open();
  const std::vector<store::DamagedState> damaged = store->set_damaged_states_aside(1).value();
  ASSERT_THAT(damaged, SizeIs(1));
  EXPECT_THAT(damaged[0].reason, HasSubstr("the file of the saved state \"before\""));
  EXPECT_EQ(damaged[0].kept_file, "/store/damaged/1-0-2.state");
  EXPECT_EQ(on_.disk.contents()["/store/damaged/1-0-2.state"], "MINE");
  EXPECT_EQ(store->read_state(1, 0, "before").error().reason, "STATE_NOT_FOUND");
  expect_rest(*store);
}

TEST_F(DamagedStates, OfAFileThatIsGone) {
  auto contents = on_.disk.contents();
  contents.erase("/store/states/1-0-2.state");
  on_.disk.set_contents(contents);
  const auto store = on_.open();
  const std::vector<store::DamagedState> damaged = store->set_damaged_states_aside(1).value();
  ASSERT_THAT(damaged, SizeIs(1));
  EXPECT_THAT(damaged[0].reason, HasSubstr("is gone"));
  EXPECT_EQ(damaged[0].kept_file, "");
  expect_rest(*store);
}

// The row no longer says which file it had, so all files of the sheet that no row names are kept.
TEST_F(DamagedStates, OfARowThatHasChanged) {
  change("UPDATE states SET number = 99 WHERE sheet = 1 AND name = 'before'");
  auto store = on_.open();
  const std::vector<store::DamagedState> damaged = store->set_damaged_states_aside(1).value();
  ASSERT_THAT(damaged, SizeIs(1));
  EXPECT_THAT(damaged[0].reason, HasSubstr("the row of the saved state \"before\" has changed"));
  EXPECT_EQ(damaged[0].kept_file, "/store/damaged/1-0-2.state");
  expect_rest(*store);
  store.reset();
  EXPECT_THAT(on_.check()->faults, IsEmpty());
  store = on_.open();
  EXPECT_EQ(on_.disk.contents()["/store/damaged/1-0-2.state"], "mine");
}

TEST_F(DamagedStates, AreNotLostWithThePower) {
  bool is_done = false;
  for (std::int64_t operations = 1; !is_done; ++operations) {
    ASSERT_LT(operations, 100);
    StoreOnLossyDisk on;
    auto contents = on_.disk.contents();
    contents["/store/states/1-0-2.state"] = "MINE";
    on.disk.set_contents(contents);
    {
      const auto store = on.open();
      on.disk.lose_power_after(operations);
      is_done = store->set_damaged_states_aside(1).ok();
    }
    SeededRandom random(static_cast<std::uint64_t>(operations));
    on.disk.restart(random);
    const auto store = on.open();
    ASSERT_NE(store, nullptr);
    ASSERT_TRUE(store->set_damaged_states_aside(1).ok());
    auto left = on.disk.contents();
    EXPECT_EQ(left["/store/damaged/1-0-2.state"], "MINE") << operations;
    EXPECT_TRUE(store->backup("/copy").ok()) << operations;
  }
}

}  // namespace
}  // namespace kerf::test
