// States: files beside the database.

#include "tests/store/fixture.h"

namespace kerf::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<std::string> described(const store::StoredSheet& sheet) {
  std::vector<std::string> found;
  for (const store::StateInfo& one : sheet.states) found.push_back(std::to_string(one.seq) + one.name);
  return found;
}

class States : public testing::Test {
 protected:
  // Appends entries up to `seq`, then saves a state.
  void save(std::int64_t seq, const std::string& content, const std::string& name = {}) {
    while (last_ < seq) store_->append(entry(1, ++last_, std::string(100, 'e')), nullptr);
    store_->save(state(1, seq, content, name), calls_.add(std::to_string(seq) + name));
    ASSERT_TRUE(store_->wait_until_durable().ok());
  }
  void open(std::int64_t sheet_bytes = 1'000'000) {
    store_.reset();
    store::StoreOptions options = on_.options();
    options.keep.sheet_bytes = sheet_bytes;
    store_ = StoreOnLossyDisk::open(options);
    if (store_->new_sheet_number() == 1) store_->create(new_sheet(1), nullptr);
  }
  store::StoredSheet sheet() { return (*store_->sheets())[0]; }

  StoreOnLossyDisk on_;
  Calls calls_;
  std::unique_ptr<store::SqliteStore> store_;
  std::int64_t last_ = 0;
};

TEST_F(States, AreReadAsTheyWereGiven) {
  open();
  const std::string large(2'500'000, 'z');
  save(0, "");
  save(2, large, "before the cut");
  open();
  const auto first = store_->read_state(1, 0);
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(first->content, "");
  EXPECT_EQ(first->tick, 5);
  const auto second = store_->read_state(1, 2, "before the cut");
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(second->content, large);
  EXPECT_EQ(second->engine, 77u);
  EXPECT_EQ(second->state_hash, 78u);
  EXPECT_EQ(second->continuation_hash, 79u);
  EXPECT_EQ(second->name, "before the cut");
  EXPECT_EQ(store_->read_state(1, 2).error().reason, "STATE_NOT_FOUND");
  EXPECT_THAT(calls_.names(), ElementsAre("0", "2before the cut"));
}

TEST_F(States, TheLastTwoAndAllNamedOnesAreKept) {
  open();
  save(1, "a");
  save(2, "b", "mine");
  save(3, "c");
  save(4, "d");
  save(4, "d later");
  save(5, "e", "mine");
  save(6, "f", "yours");
  EXPECT_THAT(described(sheet()), ElementsAre("6yours", "5mine", "4", "3"));
  EXPECT_EQ(store_->read_state(1, 4)->content, "d later");
  save(7, "g");
  EXPECT_THAT(described(sheet()), ElementsAre("7", "6yours", "5mine", "4"));
  open();
  EXPECT_THAT(*on_.disk.list("/store/states"), SizeIs(4));
  EXPECT_TRUE(on_.check().error().reason == "STORE_IN_USE");
  store_.reset();
  EXPECT_THAT(on_.check()->faults, IsEmpty());
}

TEST_F(States, ANamedOneIsRemoved) {
  open();
  save(3, "first", "mine");
  save(4, "second");
  store_->remove_state(1, "mine", calls_.add("removed"));
  store_->remove_state(1, "yours", calls_.add("nothing removed"));
  ASSERT_TRUE(store_->wait_until_durable().ok());
  EXPECT_THAT(described(sheet()), ElementsAre("4"));
  open();
  EXPECT_THAT(described(sheet()), ElementsAre("4"));
}

TEST_F(States, EntriesAreKeptUpToALimit) {
  open(500);
  save(2, "a");
  save(4, "b");
  EXPECT_EQ(sheet().first_seq, 1) << "400 bytes";
  save(6, "c", "named");
  EXPECT_EQ(sheet().first_seq, 3) << "600 bytes: those up to the second-last unnamed state go";
  EXPECT_EQ(store_->entries(1, 2)->size(), 4u);
  EXPECT_EQ(store_->entries(1, 1).error().reason, "JOURNAL_DAMAGED");
  EXPECT_THAT(described(sheet()), ElementsAre("6named", "4", "2"));
  save(7, "d");
  EXPECT_EQ(sheet().first_seq, 3) << "500 bytes";
  save(8, "e");
  EXPECT_EQ(sheet().first_seq, 8);
  open(500);
  EXPECT_EQ(sheet().last_seq, 8);
  store_.reset();
  EXPECT_THAT(on_.check()->faults, IsEmpty());
}

TEST_F(States, FilesThatNoRowNamesAreRemovedAtTheNextStart) {
  open();
  save(1, "a");
  store_.reset();
  auto contents = on_.disk.contents();
  contents["/store/states/1-9-9.state.new"] = "half";
  on_.disk.set_contents(contents);
  EXPECT_THAT(on_.check()->orphan_files, ElementsAre("1-9-9.state.new"));
  open();
  EXPECT_THAT(*on_.disk.list("/store/states"), ElementsAre("1-1-1.state"));
}

TEST_F(States, EntriesAreCommittedBetweenThePiecesOfALargeState) {
  open();
  ASSERT_TRUE(store_->wait_until_durable().ok());
  Calls calls;
  // A callback gives the next entry, so each is a transaction of its own while the state is under way.
  std::function<void(std::int64_t)> append = [&](std::int64_t seq) {
    store_->append(entry(1, seq), [&, seq] {
      calls.add(std::to_string(seq))();
      if (seq < 4) append(seq + 1);
    });
  };
  HeldStore held(*store_);
  store_->save(state(1, 0, std::string(8'000'000, 's')), calls.add("state"));
  append(1);
  held.release();
  while (calls.names().size() < 5) ASSERT_TRUE(store_->wait_until_durable().ok());
  EXPECT_THAT(calls.names(), ElementsAre("1", "2", "3", "4", "state"));
}

TEST_F(States, ADamagedFileIsNotRead) {
  open();
  save(1, "good");
  save(2, "bad");
  store_.reset();
  auto contents = on_.disk.contents();
  contents["/store/states/1-2-2.state"] = "BAD";
  on_.disk.set_contents(contents);
  EXPECT_THAT(on_.check()->faults, ElementsAre(HasSubstr("the file of the state after entry 2")));
  open();
  EXPECT_EQ(store_->read_state(1, 2).error().reason, "STATE_DAMAGED");
  EXPECT_EQ(store_->read_state(1, 2).error().code, ErrorCode::kDataLoss);
  EXPECT_EQ(store_->read_state(1, 1)->content, "good");
}

}  // namespace
}  // namespace kerf::test
