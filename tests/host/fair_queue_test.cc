#include "server/service/host/fair_queue.h"

#include <algorithm>
#include <functional>
#include <string>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

using Queue = FairQueue<std::string>;

// Takes `count` turns of which each uses the same time, and returns the items, one letter each.
std::string turns(Queue& queue, int count, const std::function<Queue::Group&(char)>& group_of, Nanoseconds each = 1ms) {
  std::string taken;
  for (int i = 0; i < count; ++i) {
    taken += queue.pop();
    queue.charge(group_of(taken.back()), each);
  }
  return taken;
}

TEST(FairQueue, AGroupKeepsItsOrder) {
  Queue queue;
  const auto all = queue.group("");
  for (const char* const item : {"a", "b", "c"}) queue.push(all, item);
  EXPECT_EQ(queue.size(), 3u);
  EXPECT_EQ(turns(queue, 3, [&](char) -> Queue::Group& { return *all; }), "abc");
  EXPECT_TRUE(queue.empty());
}

TEST(FairQueue, GroupsShareTheTimeNotTheTurns) {
  Queue queue;
  const auto slow = queue.group("slow"), quick = queue.group("quick");
  for (int i = 0; i < 10; ++i) queue.push(slow, "S");
  for (int i = 0; i < 30; ++i) queue.push(quick, "q");
  std::string taken;
  for (int i = 0; i < 16; ++i) {
    taken += queue.pop();
    queue.charge(taken.back() == 'S' ? *slow : *quick, taken.back() == 'S' ? 30ms : 10ms);
  }
  EXPECT_EQ(std::count(taken.begin(), taken.end(), 'S'), 4) << taken;
}

TEST(FairQueue, AGroupThatRestedSavesUpNoTime) {
  Queue queue;
  const auto busy = queue.group("busy"), resting = queue.group("resting");
  const auto group_of = [&](char item) -> Queue::Group& { return item == 'b' ? *busy : *resting; };
  for (int i = 0; i < 100; ++i) queue.push(busy, "b");
  turns(queue, 90, group_of);
  for (int i = 0; i < 10; ++i) queue.push(resting, "r");
  const std::string taken = turns(queue, 10, group_of);
  EXPECT_EQ(taken[0], 'r') << "it has its turn at once";
  EXPECT_EQ(std::count(taken.begin(), taken.end(), 'b'), 5) << taken;
}

TEST(FairQueue, AGroupOfANameIsTheSameAsLongAsItIsKept) {
  Queue queue;
  auto first = queue.group("lab");
  EXPECT_EQ(queue.group("lab"), first);
  EXPECT_NE(queue.group("shop"), first);
  queue.push(first, "x");
  first.reset();
  EXPECT_EQ(queue.pop(), "x") << "items keep it";
}

}  // namespace
}  // namespace kerf::host
