// The limits of what is not yet durable.

#include "server/service/store/write_queue.h"

#include <atomic>

#include "tests/store/fixture.h"

namespace kerf::test {
namespace {

using testing::HasSubstr;

TEST(StalledStore, AppendReturnsAndRoomEnds) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  Calls calls;
  const std::int64_t busy = store->new_sheet_number();
  const std::int64_t other = store->new_sheet_number();
  store->create(new_sheet(busy), nullptr);
  store->create(new_sheet(other), nullptr);
  ASSERT_TRUE(store->wait_until_durable().ok());
  on.disk.hang(true);
  for (std::int64_t seq = 1; seq <= 64; ++seq) {
    EXPECT_TRUE(store->check_room(busy).ok()) << seq;
    store->append(entry(busy, seq), calls.add(std::to_string(seq)));
  }
  const Status refused = store->check_room(busy);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(refused.error().reason, "STORAGE_STALLED");
  EXPECT_TRUE(store->check_room(other).ok());
  on.now_ns = 1'000'000'000;
  EXPECT_TRUE(store->check_room(other).ok());
  on.now_ns = 10'000'000'000;
  EXPECT_EQ(store->check_room(other).error().reason, "STORAGE_STALLED");
  EXPECT_THAT(store->check_room(other).error().message, HasSubstr("10000 ms"));
  EXPECT_TRUE(calls.names().empty());
  on.disk.hang(false);
  EXPECT_TRUE(store->wait_until_durable().ok());
  EXPECT_EQ(calls.names().size(), 64u);
  EXPECT_TRUE(store->check_room(busy).ok());
  EXPECT_EQ(store->entries(busy, 0)->size(), 64u);
}

TEST(WriteQueue, BoundsBytesAndTheWhole) {
  store::QueueLimits limits;
  limits.sheet_bytes = 100;
  limits.changes = 3;
  limits.bytes = 250;
  store::WriteQueue queue(limits, [] { return std::chrono::nanoseconds(0); });
  queue.push(store::Change{entry(1, 1, std::string(90, 'x'), {request("key", "answer")}), nullptr});
  EXPECT_TRUE(queue.check_room(1).ok());  // 99 bytes
  queue.push(store::Change{entry(1, 2, "x"), nullptr});
  EXPECT_THAT(queue.check_room(1).error().message, HasSubstr("2 changes of the sheet with 100 bytes"));
  EXPECT_TRUE(queue.check_room(2).ok());
  queue.push(store::Change{entry(2, 1, "x"), nullptr});
  EXPECT_THAT(queue.check_room(3).error().message, HasSubstr("3 changes with 101 bytes"));
  const store::WriteQueue::Taken taken = queue.take(std::nullopt);
  EXPECT_FALSE(queue.check_room(3).ok()) << "taken, and not durable";
  EXPECT_EQ(queue.waiting().changes, 3u);
  EXPECT_EQ(queue.waiting().bytes, 101u);
  queue.give_room(taken.changes);
  EXPECT_TRUE(queue.check_room(1).ok());
  queue.push(store::Change{entry(4, 1, std::string(250, 'x')), nullptr});
  EXPECT_THAT(queue.check_room(3).error().message, HasSubstr("1 changes with 250 bytes"));
}

TEST(WriteQueue, TellsOfAFullDiskAndOfAFailure) {
  store::WriteQueue queue({}, [] { return std::chrono::nanoseconds(0); });
  queue.set_full(true);
  EXPECT_EQ(queue.check_room(1).error().reason, "STORAGE_FULL");
  EXPECT_EQ(queue.check_room(1).error().code, ErrorCode::kResourceExhausted);
  queue.set_full(false);
  EXPECT_TRUE(queue.check_room(1).ok());
  queue.fail("the disk is broken");
  EXPECT_EQ(queue.check_room(1).error().reason, "STORAGE_FAILED");
  EXPECT_EQ(queue.wait_until_done().error().message, "the disk is broken");
}

}  // namespace
}  // namespace kerf::test
