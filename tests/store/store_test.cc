// The contract of host::Journal, by a store on a disk in memory.

#include <future>
#include <thread>

#include "tests/store/fixture.h"

namespace kerf::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Store, KeepsWhatItWasGiven) {
  StoreOnLossyDisk on;
  {
    const auto store = on.open();
    const std::int64_t sheet = store->new_sheet_number();
    EXPECT_EQ(sheet, 1);
    store->create(new_sheet(sheet, {request("Create a", "made")}), nullptr);
    store->append(entry(sheet, 1, "cut", {request("Cut b", "done"), request("Cut c", "")}), nullptr);
    store->append(entry(sheet, 2, std::string("\0\1\xff", 3)), nullptr);
    store->mark({{sheet, 44}});
    EXPECT_TRUE(store->wait_until_durable().ok());
  }
  const auto store = on.open();
  const auto sheets = store->sheets();
  ASSERT_TRUE(sheets.ok());
  ASSERT_EQ(sheets->size(), 1u);
  const store::StoredSheet& sheet = sheets->front();
  EXPECT_EQ(sheet.id, "sheet-1");
  EXPECT_EQ(sheet.scene, "scene of 1");
  EXPECT_EQ(sheet.created_unix_us, 1'000'000);
  EXPECT_EQ(sheet.first_seq, 1);
  EXPECT_EQ(sheet.last_seq, 2);
  EXPECT_EQ(sheet.mark, 44);
  const auto entries = store->entries(1, 0);
  ASSERT_TRUE(entries.ok());
  ASSERT_EQ(entries->size(), 2u);
  EXPECT_EQ((*entries)[0].content, "cut");
  EXPECT_EQ((*entries)[0].tick, 10);
  EXPECT_EQ((*entries)[1].content, std::string("\0\1\xff", 3));
  EXPECT_EQ((*entries)[1].state_hash, 1002u);
  EXPECT_EQ(store->entries(1, 1)->size(), 1u);
  const auto requests = store->requests(10, 1000);
  ASSERT_EQ(requests->requests.size(), 3u);
  EXPECT_EQ(requests->requests[0].request.key, "Cut c");
  EXPECT_EQ(requests->requests[0].request.reply, "");
  EXPECT_EQ(requests->requests[1].request.key, "Cut b");
  EXPECT_EQ(requests->requests[1].request.body_hash, 17u);
  EXPECT_EQ(requests->requests[1].seq, 1);
  EXPECT_EQ(requests->requests[2].request.key, "Create a");
  EXPECT_EQ(requests->requests[2].seq, 0);
  EXPECT_EQ(store->new_sheet_number(), 2);
}

TEST(Store, CallsBackInOrderOfAllSheets) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  Calls calls;
  for (const std::int64_t sheet : {store->new_sheet_number(), store->new_sheet_number()}) {
    store->create(new_sheet(sheet), calls.add("create " + std::to_string(sheet)));
  }
  store->append(entry(2, 1), calls.add("2/1"));
  store->append(entry(1, 1), calls.add("1/1"));
  store->append(entry(2, 2), calls.add("2/2"));
  store->remove(1, {}, calls.add("remove 1"));
  EXPECT_TRUE(store->wait_until_durable().ok());
  EXPECT_THAT(calls.names(), ElementsAre("create 1", "create 2", "2/1", "1/1", "2/2", "remove 1"));
}

TEST(Store, WritesAllThatWaitsAsOneTransaction) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  const auto operations_of = [&](int entries) {
    const std::int64_t sheet = store->new_sheet_number();
    store->create(new_sheet(sheet), nullptr);
    EXPECT_TRUE(store->wait_until_durable().ok());
    HeldStore held(*store);
    const std::int64_t before = on.disk.num_operations();
    for (int i = 1; i <= entries; ++i) store->append(entry(sheet, i), nullptr);
    held.release();
    EXPECT_TRUE(store->wait_until_durable().ok());
    return on.disk.num_operations() - before;
  };
  const std::int64_t one = operations_of(1);
  EXPECT_LE(operations_of(40), one + 4);  // some pages more, and one sync as well
}

TEST(Store, AnEntryAndItsRequestsAreThereTogether) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  const std::int64_t sheet = store->new_sheet_number();
  std::size_t found = 0;
  store->create(new_sheet(sheet), nullptr);
  store->append(entry(sheet, 1, "x", {request("a"), request("b")}), nullptr);
  EXPECT_TRUE(store->wait_until_durable().ok());
  found = store->requests(10, 1000)->requests.size();
  EXPECT_EQ(found, 2u);
  // A repeat that the host no longer knew replaces the answer.
  store->append(entry(sheet, 2, "y", {request("a", "later")}), nullptr);
  EXPECT_TRUE(store->wait_until_durable().ok());
  const auto requests = store->requests(10, 1000);
  ASSERT_EQ(requests->requests.size(), 2u);
  EXPECT_EQ(requests->requests[0].request.reply, "later");
  EXPECT_EQ(requests->requests[0].seq, 2);
}

TEST(Store, ARemovedSheetLeavesItsRequestsAndItsNumber) {
  StoreOnLossyDisk on;
  {
    const auto store = on.open();
    const std::int64_t sheet = store->new_sheet_number();
    store->create(new_sheet(sheet), nullptr);
    store->append(entry(sheet, 1, "x", {request("a")}), nullptr);
    store->save(state(sheet, 1, "state"), nullptr);
    EXPECT_TRUE(store->wait_until_durable().ok());
    store->mark({{sheet, 4}});
    store->remove(sheet, {request("delete")}, nullptr);
    // A change that comes too late leaves its request.
    store->append(entry(sheet, 2, "x", {request("late")}), nullptr);
    store->save(state(sheet, 2, "late"), nullptr);
    EXPECT_TRUE(store->wait_until_durable().ok());
    EXPECT_THAT(*store->sheets(), IsEmpty());
    EXPECT_EQ(store->requests(10, 1000)->requests.size(), 3u);
    const auto info = store->info();
    EXPECT_EQ(info->entries, 0);
    EXPECT_EQ(info->states, 0);
    EXPECT_EQ(info->sheets, 0);
  }
  const auto store = on.open();
  EXPECT_THAT(*store->sheets(), IsEmpty());
  EXPECT_THAT(*on.disk.list("/store/states"), IsEmpty());
  EXPECT_EQ(store->new_sheet_number(), 2);
}

TEST(Store, AnEntryTakesALaterMarkBack) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  const std::int64_t sheet = store->new_sheet_number();
  store->create(new_sheet(sheet), nullptr);
  const auto mark_after = [&](std::int64_t mark, std::int64_t seq, bool are_together) {
    HeldStore held(*store);
    store->mark({{sheet, mark}});
    if (!are_together) {
      held.release();
      EXPECT_TRUE(store->wait_until_durable().ok());
    }
    store->append(entry(sheet, seq), nullptr);  // at tick 10 * seq
    if (are_together) held.release();
    EXPECT_TRUE(store->wait_until_durable().ok());
    return (*store->sheets())[0].mark;
  };
  EXPECT_EQ(mark_after(500, 1, true), 10);
  EXPECT_EQ(mark_after(500, 2, false), 20);
  EXPECT_EQ(mark_after(25, 3, true), 25);
  store->mark({{sheet, 31}});
  EXPECT_TRUE(store->wait_until_durable().ok());
  EXPECT_EQ((*store->sheets())[0].mark, 31);
}

TEST(Store, EntriesAfterANumberAreRemovedWithTheirRequests) {
  StoreOnLossyDisk on;
  std::unique_ptr<store::SqliteStore> store = on.open();
  ASSERT_EQ(store->new_sheet_number(), 1);
  store->create(new_sheet(1), nullptr);
  store->append(entry(1, 1, {}, {request("kept")}), nullptr);
  store->append(entry(1, 2, {}, {request("gone")}), nullptr);
  ASSERT_TRUE(store->wait_until_durable().ok());
  ASSERT_TRUE(store->remove_entries_after(1, 1).ok());
  const auto requests = store->requests(10, 1000);
  ASSERT_EQ(requests->requests.size(), 1U);
  EXPECT_EQ(requests->requests[0].request.key, "kept");
  store->append(entry(1, 2, "another change"), nullptr);
  ASSERT_TRUE(store->wait_until_durable().ok());
  EXPECT_EQ(store->entries(1, 1)->at(0).content, "another change");
  store.reset();
  EXPECT_TRUE(on.check()->faults.empty());
}

TEST(Store, AnEntryThatDoesNotFollowEndsTheStore) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  Calls calls;
  const std::int64_t sheet = store->new_sheet_number();
  store->create(new_sheet(sheet), nullptr);
  store->append(entry(sheet, 2), calls.add("2"));
  EXPECT_EQ(store->wait_until_durable().error().reason, "STORAGE_FAILED");
  EXPECT_THAT(on.failures(), ElementsAre(HasSubstr("JOURNAL_ORDER: entry 2 of sheet 1")));
  EXPECT_THAT(calls.names(), IsEmpty());
}

TEST(Store, CallbacksOfAStoreThatIsDestroyedAreNotCalled) {
  StoreOnLossyDisk on;
  auto store = on.open();
  Calls calls;
  const std::int64_t sheet = store->new_sheet_number();
  store->create(new_sheet(sheet), calls.add("create"));
  EXPECT_TRUE(store->wait_until_durable().ok());
  on.disk.hang(true);
  store->append(entry(sheet, 1), calls.add("1"));
  std::thread end([&] { store.reset(); });
  on.disk.hang(false);
  end.join();
  // Destruction may have begun before or after the callback; the next store says which.
  const std::size_t num_calls = calls.names().size();
  EXPECT_GE((*on.open()->sheets())[0].last_seq, static_cast<std::int64_t>(num_calls) - 1);
}

TEST(Store, OldRequestsBeyondANumberAreRemoved) {
  StoreOnLossyDisk on;
  store::StoreOptions options = on.options();
  options.keep.requests = 2;
  const auto store = StoreOnLossyDisk::open(options);
  const std::int64_t sheet = store->new_sheet_number();
  store->create(new_sheet(sheet), nullptr);
  for (const std::int64_t seq : {1, 2, 3}) {
    store->append(entry(sheet, seq, "x", {request("r" + std::to_string(seq))}), nullptr);
    EXPECT_TRUE(store->wait_until_durable().ok());
    on.unix_us += 1'000'000;
  }
  EXPECT_EQ(store->prune()->requests, 0);
  EXPECT_EQ(store->requests(10, 1000)->requests.size(), 3u) << "all are younger than a day";
  on.unix_us += std::int64_t{24} * 3600 * 1'000'000;
  EXPECT_EQ(store->prune()->requests, 1);
  const auto kept = store->requests(10, 1000);
  ASSERT_EQ(kept->requests.size(), 2u);
  EXPECT_EQ(kept->requests[0].request.key, "r3");
  EXPECT_EQ(kept->requests[1].request.key, "r2");
  EXPECT_EQ(store->requests(1, 1000)->requests.size(), 1u);
  EXPECT_EQ(store->requests(10, 9)->requests.size(), 1u);  // "r3" and "done" are 6 bytes
}

TEST(Store, RowsOfDeletedSheetsArePruned) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  for (int i = 0; i < 3; ++i) {
    const std::int64_t sheet = store->new_sheet_number();
    store->create(new_sheet(sheet), nullptr);
    store->remove(sheet, {}, nullptr);
  }
  ASSERT_TRUE(store->wait_until_durable().ok());
  EXPECT_EQ(store->prune()->sheets, 2) << "that of the largest number stays";
  EXPECT_EQ(store->prune()->sheets, 0);
}

TEST(Store, ASheetIsQuarantinedAlone) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  for (const std::int64_t sheet : {store->new_sheet_number(), store->new_sheet_number()}) {
    store->create(new_sheet(sheet), nullptr);
    store->append(entry(sheet, 1), nullptr);
  }
  EXPECT_TRUE(store->wait_until_durable().ok());
  EXPECT_TRUE(store->quarantine(1, "entry 1 does not replay").ok());
  EXPECT_EQ(store->quarantine(7, "").error().reason, "SHEET_NOT_FOUND");
  const auto sheets = store->sheets();
  ASSERT_EQ(sheets->size(), 2u);
  EXPECT_TRUE((*sheets)[0].is_quarantined);
  EXPECT_EQ((*sheets)[0].reason, "entry 1 does not replay");
  EXPECT_EQ((*sheets)[0].scene, "scene of 1");
  EXPECT_EQ((*sheets)[0].last_seq, 1);
  EXPECT_FALSE((*sheets)[1].is_quarantined);
  const std::vector<store::QuarantinedSheet> aside = store->info()->quarantined;
  ASSERT_EQ(aside.size(), 1u);
  EXPECT_EQ(aside[0].sheet, 1);
  EXPECT_EQ(aside[0].id, "sheet-1");
  EXPECT_EQ(aside[0].reason, "entry 1 does not replay");
  EXPECT_TRUE(on.failures().empty());
}

}  // namespace
}  // namespace kerf::test
