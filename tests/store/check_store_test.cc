// check_store() finds each kind of fault, and changes nothing.

#include "server/service/store/check_store.h"

#include "tests/store/fixture.h"

namespace kerf::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CheckStore : public testing::Test {
 protected:
  void SetUp() override {
    const auto store = on_.open();
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    for (std::int64_t seq = 1; seq <= 6; ++seq) {
      store->append(entry(1, seq, {}, {request("Cut " + std::to_string(seq))}), nullptr);
    }
    store->save(state(1, 2, "two"), nullptr);
    store->save(state(1, 4, "four"), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
  }
  // Changes the tables behind the store's back.
  void change(const std::string& sql) {
    auto database = store::Database::open("/store/kerf.db", on_.options().vfs);
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE(database->execute("PRAGMA locking_mode = EXCLUSIVE").ok());
    ASSERT_TRUE(database->execute(sql).ok()) << database->error(0, "").message;
  }
  std::vector<std::string> faults() { return on_.check()->faults; }

  StoreOnLossyDisk on_;
};

TEST_F(CheckStore, SaysWhatIsThere) {
  const auto before = on_.disk.contents();
  const auto report = on_.check();
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_THAT(report->orphan_files, IsEmpty());
  EXPECT_EQ(report->info.sheets, 1);
  EXPECT_EQ(report->info.entries, 6);
  EXPECT_EQ(report->info.requests, 6);
  EXPECT_EQ(report->info.states, 2);
  EXPECT_EQ(report->info.state_bytes, 7);
  EXPECT_EQ(report->info.entry_bytes, 6 * 13);
  EXPECT_GT(report->info.database_bytes, 4096);
  EXPECT_EQ(on_.disk.contents(), before);
}

TEST_F(CheckStore, ReadsTheLogOfAKilledStoreAndLeavesIt) {
  std::map<std::string, std::string> contents;
  {
    const auto store = on_.open();
    store->append(entry(1, 7), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
    contents = on_.disk.contents();
  }
  on_.disk.set_contents(contents);
  const auto report = on_.check();
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_EQ(report->info.entries, 7);
  EXPECT_EQ(on_.disk.contents(), contents);
}

TEST_F(CheckStore, FindsAGap) {
  change("DELETE FROM journal WHERE seq = 5");
  EXPECT_THAT(faults(), ElementsAre("sheet 1 \"sheet-1\": entry 5 of sheet 1 is missing"));
  EXPECT_EQ(on_.open()->entries(1, 0).error().code, ErrorCode::kDataLoss);
}

TEST_F(CheckStore, FindsAnEntryOfNoSheet) {
  change("UPDATE journal SET sheet = 3 WHERE seq = 6; DELETE FROM requests");
  EXPECT_THAT(faults(), ElementsAre(HasSubstr("a row for entry 6 of sheet 3, which does not belong there")));
  EXPECT_EQ(store::SqliteStore::open(on_.options()).error().reason, "STORE_DAMAGED");
}

TEST_F(CheckStore, FindsTooMuchRemoved) {
  change("DELETE FROM journal WHERE seq <= 2");
  EXPECT_THAT(faults(), IsEmpty()) << "the second-last state is enough";
  change("DELETE FROM journal WHERE seq <= 3");
  EXPECT_THAT(faults(), ElementsAre("sheet 1 \"sheet-1\": its oldest entry is 4, and entry 3 is needed"));
}

TEST_F(CheckStore, FindsChangedRows) {
  change("UPDATE journal SET tick = tick + 1 WHERE seq = 6");
  change("UPDATE requests SET reply = 'other' WHERE key = 'Cut 1'");
  change("UPDATE states SET tick = 0 WHERE seq = 4");
  change("UPDATE sheets SET scene = 'other'");
  EXPECT_THAT(faults(), ElementsAre(HasSubstr("its row has changed"), HasSubstr("the row of a state has changed"),
                                    HasSubstr("entry 6 of sheet 1 has changed"), HasSubstr("1 answers have changed")));
}

TEST_F(CheckStore, FindsARequestWithoutItsEntry) {
  change("DELETE FROM journal WHERE seq = 6");
  EXPECT_THAT(faults(), ElementsAre("sheet 1 \"sheet-1\": entry 6 of request \"Cut 6\" is not there"));
}

TEST_F(CheckStore, FindsAStateWithoutItsEntriesOrFile) {
  auto contents = on_.disk.contents();
  contents.erase("/store/states/1-4-2.state");
  on_.disk.set_contents(contents);
  change("DELETE FROM requests; DELETE FROM journal WHERE seq >= 4");
  EXPECT_THAT(faults(), ElementsAre("sheet 1 \"sheet-1\": a state follows entry 4, which is not there",
                                    "sheet 1 \"sheet-1\": the file of the state after entry 4, "
                                    "\"/store/states/1-4-2.state\", is gone"));
}

TEST_F(CheckStore, FindsDamagedPages) {
  auto contents = on_.disk.contents();
  std::string& pages = contents["/store/kerf.db"];
  for (std::size_t page = 4096; page < pages.size(); page += 4096) pages[page + 5] ^= 1;  // where its cells begin
  on_.disk.set_contents(contents);
  const auto report = on_.check();
  EXPECT_TRUE(!report.ok() || !report->faults.empty());
  EXPECT_EQ(store::SqliteStore::open(on_.options()).error().reason, "STORE_DAMAGED");
}

}  // namespace
}  // namespace kerf::test
