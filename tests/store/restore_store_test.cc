// A store is made again from a backup, or refused with what is wrong.

#include "server/service/store/restore_store.h"

#include "tests/store/fixture.h"

namespace kerf::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class RestoreStore : public testing::Test {
 protected:
  void SetUp() override {
    const auto store = on_.open();
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    for (const std::int64_t seq : {1, 2})
      store->append(entry(1, seq, {}, {request("r" + std::to_string(seq))}), nullptr);
    store->append(entry(2, 1), nullptr);
    store->save(state(1, 2, "two"), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
    ASSERT_TRUE(store->backup("/backup").ok());
  }
  Result<store::StoreReport> restore() { return store::restore_store("/backup", "/new", on_.disk, on_.options().vfs); }
  std::unique_ptr<store::SqliteStore> open_new() {
    store::StoreOptions options = on_.options();
    options.folder = "/new";
    return StoreOnLossyDisk::open(options);
  }
  void change_backup(const std::string& sql) {
    auto database = store::Database::open("/backup/kerf.db", on_.options().vfs);
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE(database->execute("PRAGMA locking_mode = EXCLUSIVE").ok());
    ASSERT_TRUE(database->execute(sql).ok()) << database->error(0, "").message;
  }
  void expect_nothing_is_made() {
    for (const auto& [path, content] : on_.disk.contents()) EXPECT_NE(path.compare(0, 4, "/new"), 0) << path;
  }

  StoreOnLossyDisk on_;
};

TEST_F(RestoreStore, CopiesAllAndLeavesTheBackup) {
  const auto before = on_.disk.contents();
  const auto restored = restore();
  ASSERT_TRUE(restored.ok()) << restored.error().message;
  EXPECT_THAT(restored->faults, IsEmpty());
  EXPECT_EQ(restored->info.sheets, 2);
  EXPECT_EQ(restored->info.entries, 3);
  for (const auto& [path, content] : before) EXPECT_EQ(on_.disk.contents()[path], content) << path;
  SeededRandom random(1);
  on_.disk.restart(random);  // as after a loss of power
  const auto store = open_new();
  EXPECT_EQ(store->sheets()->size(), 2u);
  EXPECT_EQ(store->entries(1, 0)->size(), 2u);
  EXPECT_EQ(store->read_state(1, 2)->content, "two");
  EXPECT_EQ(store->requests(10, 1000)->requests.size(), 2u);
  EXPECT_EQ(store->new_sheet_number(), 3);
}

TEST_F(RestoreStore, OverwritesNothing) {
  ASSERT_TRUE(restore().ok());
  const auto before = on_.disk.contents();
  EXPECT_EQ(restore().error().reason, "FOLDER_NOT_EMPTY");
  EXPECT_EQ(on_.disk.contents(), before);
}

TEST_F(RestoreStore, CopiesWhatIsDamagedInSheetsAndSaysSo) {
  change_backup("UPDATE journal SET tick = tick + 1");
  auto contents = on_.disk.contents();
  contents.erase("/backup/states/1-2-1.state");
  on_.disk.set_contents(contents);
  const auto restored = restore();
  ASSERT_TRUE(restored.ok()) << restored.error().message;
  EXPECT_THAT(restored->faults, ElementsAre(HasSubstr("sheet 1 \"sheet-1\": entry 1 of sheet 1 has changed"),
                                            HasSubstr("1-2-1.state"), HasSubstr("entry 1 of sheet 2 has changed")));
  const auto store = open_new();
  EXPECT_EQ(store->sheets()->size(), 2u);
  EXPECT_EQ(store->set_damaged_states_aside(1)->size(), 1u);
}

TEST_F(RestoreStore, RefusesABackupThatNoServerCouldOpen) {
  change_backup("DELETE FROM sheets WHERE sheet = 1");
  const auto refused = restore();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kDataLoss);
  EXPECT_EQ(refused.error().reason, "STORE_DAMAGED");
  EXPECT_THAT(refused.error().message, HasSubstr("does not belong there"));
  expect_nothing_is_made();
}

TEST_F(RestoreStore, LeavesFilesOfOthersAlone) {
  auto contents = on_.disk.contents();
  contents["/new.part/letter.txt"] = "mine";
  on_.disk.set_contents(contents);
  EXPECT_EQ(restore().error().reason, "FOLDER_NOT_EMPTY");
  EXPECT_EQ(on_.disk.contents()["/new.part/letter.txt"], "mine");
}

TEST_F(RestoreStore, NeedsAStore) {
  EXPECT_EQ(store::restore_store("/none", "/new", on_.disk, on_.options().vfs).error().reason, "STORE_NOT_FOUND");
  expect_nothing_is_made();
}

// Otherwise one damaged sheet would make every later backup useless.
TEST_F(RestoreStore, CopiesASheetThatWasSetAsideAsItIs) {
  change_backup("UPDATE journal SET tick = tick + 1 WHERE sheet = 2");
  {
    store::StoreOptions options = on_.options();
    options.folder = "/backup";
    ASSERT_TRUE(StoreOnLossyDisk::open(options)->quarantine(2, "entry 1 has changed").ok());
  }
  const auto report = store::check_store("/backup", on_.disk, on_.options().vfs);
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_EQ(report->known_faults.size(), 1u);
  const auto restored = restore();
  ASSERT_TRUE(restored.ok()) << restored.error().message;
  EXPECT_THAT(restored->faults, IsEmpty());
  EXPECT_EQ(restored->info.quarantined.size(), 1u);
  EXPECT_EQ(open_new()->entries(1, 0)->size(), 2u);
}

}  // namespace
}  // namespace kerf::test
