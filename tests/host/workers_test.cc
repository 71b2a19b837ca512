#include "server/service/host/workers.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <future>
#include <latch>
#include <memory>
#include <mutex>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kNever{0};   // takes on a thread
constexpr Nanoseconds kSoon{1ms};  // tests that rely on it wait for what another thread does, however long that takes

std::vector<Workers::Strand> strands_of(Workers& workers, int count) {
  std::vector<Workers::Strand> strands;
  strands.reserve(static_cast<std::size_t>(count));
  for (int s = 0; s < count; ++s) strands.push_back(workers.make_strand());
  return strands;
}

std::vector<int> count_to(int end) {
  std::vector<int> numbers(static_cast<std::size_t>(end));
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

// For what must not happen: as long as others that are as impatient take to take on ten threads, one after another.
void let_others_take_on_threads() {
  Workers workers({.num_threads = 1, .long_work = kSoon});
  const Workers::Strand late = workers.make_strand();
  const Workers::Strand strand = workers.make_strand();
  for (int i = 0; i < 10; ++i) {
    std::promise<void> taken_on;
    late.post([is_taken_on = taken_on.get_future().share()] { is_taken_on.wait(); });
    strand.post([&] { taken_on.set_value(); });
    workers.wait_idle();
  }
}

TEST(Workers, AStrandKeepsItsOrderAndRunsOneAtATime) {
  Workers workers({.num_threads = 4, .long_work = kNever});
  const std::vector<Workers::Strand> strands = strands_of(workers, 3);
  std::vector<std::vector<int>> seen(3);
  for (int i = 0; i < 300; ++i) {
    std::vector<int>& mine = seen[static_cast<std::size_t>(i % 3)];
    EXPECT_TRUE(strands[static_cast<std::size_t>(i % 3)].post([&mine, i] { mine.push_back(i / 3); }));
  }
  workers.wait_idle();
  for (const std::vector<int>& order : seen) EXPECT_EQ(order, count_to(100));
  workers.join();
  EXPECT_FALSE(strands[0].post([] {}));
}

TEST(Workers, AGroupThatHasUsedLessTimeHasTheNextTurn) {
  Workers workers({.num_threads = 1, .long_work = kNever});
  const Workers::Strand held = workers.make_strand("busy");
  const std::vector<Workers::Strand> busy = {workers.make_strand("busy"), workers.make_strand("busy")};
  const Workers::Strand other = workers.make_strand("other");
  std::promise<void> begun, released;
  std::string order;
  held.post([&] {
    begun.set_value();
    released.get_future().wait();
  });
  begun.get_future().wait();
  for (const Workers::Strand& strand : busy) strand.post([&order] { order += 'b'; });
  other.post([&order] { order += 'o'; });
  released.set_value();
  workers.wait_idle();
  EXPECT_EQ(order, "obb");
}

TEST(Workers, JoinWaitsForWhatWorkPosts) {
  Workers workers({.num_threads = 2, .long_work = kNever});
  const Workers::Strand strand = workers.make_strand();
  int depth = 0;
  std::function<void()> deeper = [&] {
    if (++depth < 50) strand.post(deeper);
  };
  strand.post(deeper);
  workers.join();
  EXPECT_EQ(depth, 50);
  workers.join();
  EXPECT_EQ(workers.num_threads(), 0U);
}

TEST(Workers, AStrandOutlivesThem) {
  auto workers = std::make_unique<Workers>(Workers::Options{.num_threads = 1, .long_work = kSoon});
  const Workers::Strand strand = workers->make_strand();
  workers.reset();
  EXPECT_FALSE(strand.post([] {}));
}

TEST(Workers, ATurnIsWhatWaitedWhenItBegan) {
  Workers workers({.num_threads = 1, .long_work = kNever});
  const std::vector<Workers::Strand> strands = strands_of(workers, 2);
  std::vector<int> seen;
  std::promise<void> all_posted;
  workers.make_strand().post([posted = all_posted.get_future().share()] { posted.wait(); });
  strands[0].post([&] {
    seen.push_back(1);
    strands[0].post([&] { seen.push_back(4); });
  });
  strands[1].post([&] { seen.push_back(3); });
  strands[0].post([&] { seen.push_back(2); });
  all_posted.set_value();
  workers.join();
  EXPECT_EQ(seen, (std::vector<int>{1, 2, 3, 4}));
}

TEST(Workers, WhatWorkHoldsGoesBeforeTheyAreIdle) {
  Workers workers({.num_threads = 1, .long_work = kSoon});
  const Workers::Strand late = workers.make_strand();
  const Workers::Strand strand = workers.make_strand();
  for (int round = 0; round < 20; ++round) {
    std::promise<void> release;
    const auto held = std::make_shared<std::shared_ptr<int>>(std::make_shared<int>(round));
    const std::weak_ptr<int> seen = *held;
    late.post([mine = std::move(*held), released = release.get_future().share()] { released.wait(); });
    strand.post([&] { release.set_value(); });
    workers.wait_idle();
    EXPECT_TRUE(seen.expired());
  }
}

TEST(Workers, LongWorkKeepsNobodyWaiting) {
  Workers workers({.num_threads = 1, .long_work = kSoon});
  const Workers::Strand late = workers.make_strand();
  const Workers::Strand strand = workers.make_strand();
  for (int round = 0; round < 20; ++round) {
    std::promise<void> release;
    std::size_t most = 0;
    late.post([released = release.get_future().share()] { released.wait(); });
    strand.post([&] {
      most = workers.num_threads();
      release.set_value();
    });
    workers.wait_idle();
    EXPECT_EQ(most, 2U);
    EXPECT_EQ(workers.num_threads(), 1U) << "the one that was replaced has gone";
  }
}

TEST(Workers, AThreadIsTakenOnForEachThatIsLate) {
  Workers workers({.num_threads = 2, .long_work = kSoon});
  const std::vector<Workers::Strand> strands = strands_of(workers, 12);
  for (int round = 0; round < 3; ++round) {
    std::latch all_at_once(12);
    std::promise<void> release;
    const std::shared_future<void> released = release.get_future().share();
    for (const Workers::Strand& strand : strands) {
      strand.post([&all_at_once, released] {
        all_at_once.count_down();
        released.wait();
      });
    }
    all_at_once.wait();
    EXPECT_EQ(workers.num_threads(), 12U);
    release.set_value();
    workers.wait_idle();
    EXPECT_EQ(workers.num_threads(), 2U);
  }
}

// The rest of the turn of a thread that was replaced, and that ends, is done by another, which has to be found.
TEST(Workers, WhatLongWorkLeavesIsTakenOver) {
  Workers workers({.num_threads = 1, .long_work = kSoon});
  const Workers::Strand first = workers.make_strand();
  const Workers::Strand second = workers.make_strand();
  std::promise<void> both_posted;
  std::promise<void> second_runs;
  std::promise<void> rest_is_done;
  workers.make_strand().post([posted = both_posted.get_future().share()] { posted.wait(); });
  first.post([runs = second_runs.get_future().share()] { runs.wait(); });
  first.post([&] { rest_is_done.set_value(); });
  second.post([&, done = rest_is_done.get_future().share()] {
    second_runs.set_value();
    done.wait();
  });
  both_posted.set_value();
  workers.wait_idle();
  EXPECT_EQ(workers.num_threads(), 1U);
}

TEST(Workers, OrderIsKeptWhereverThreadsComeAndGo) {
  constexpr int kStrands = 5;
  constexpr int kPieces = 60;
  Workers workers({.num_threads = 2, .long_work = kSoon});
  const std::vector<Workers::Strand> strands = strands_of(workers, kStrands);
  const Workers::Strand liberator = workers.make_strand();
  std::vector<std::vector<int>> seen(kStrands);
  std::vector<std::atomic<int>> at_once(kStrands);
  std::vector<std::promise<void>> releases(kPieces / 20);
  std::vector<std::shared_future<void>> released;
  released.reserve(releases.size());
  for (std::promise<void>& release : releases) released.push_back(release.get_future().share());
  const auto piece = [&](std::size_t strand, int i) {
    EXPECT_EQ(++at_once[strand], 1);
    if (i % 20 == 10) released[static_cast<std::size_t>(i / 20)].wait();
    seen[strand].push_back(i);
    --at_once[strand];
  };
  for (int i = 0; i < kPieces; ++i) {
    for (std::size_t s = 0; s < kStrands; ++s) strands[s].post([&piece, s, i] { piece(s, i); });
  }
  for (std::promise<void>& release : releases) liberator.post([&release] { release.set_value(); });
  workers.wait_idle();
  for (const std::vector<int>& order : seen) EXPECT_EQ(order, count_to(kPieces));
  EXPECT_EQ(workers.num_threads(), 2U);
}

TEST(Workers, JoinWaitsForLongWorkAndForWhatItPosts) {
  Workers workers({.num_threads = 1, .long_work = kSoon});
  const Workers::Strand late = workers.make_strand();
  const Workers::Strand strand = workers.make_strand();
  std::promise<void> release;
  bool posted = false;
  bool done = false;
  late.post([&, released = release.get_future().share()] {
    released.wait();
    posted = strand.post([&] { done = true; });
  });
  strand.post([&] { release.set_value(); });
  workers.join();
  EXPECT_TRUE(posted);
  EXPECT_TRUE(done);
}

TEST(Workers, NoMoreAreTakenOnThanTheBound) {
  constexpr std::size_t kMost = 1 + Workers::Options().max_taken_on;
  constexpr std::size_t kPieces = kMost + 15;
  Workers workers({.num_threads = 1, .long_work = kSoon});
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t begun = 0;
  std::size_t ended = 0;
  std::size_t may_end = 0;
  std::size_t at_once = 0;
  const auto long_work = [&] {
    std::unique_lock lock(mutex);
    at_once = std::max(at_once, ++begun - ended);
    changed.notify_all();
    changed.wait(lock, [&] { return ended < may_end; });
    ++ended;
  };
  for (const Workers::Strand& strand : strands_of(workers, static_cast<int>(kPieces))) strand.post(long_work);
  std::unique_lock lock(mutex);
  for (std::size_t i = kMost; i <= kPieces; ++i) {  // one after another, as room for it is made
    changed.wait(lock, [&] { return begun >= i; });
    if (i == kMost) {
      lock.unlock();
      let_others_take_on_threads();
      lock.lock();
    }
    EXPECT_EQ(workers.num_threads(), kMost);
    ++may_end;
    changed.notify_all();
  }
  may_end = kPieces;
  changed.notify_all();
  lock.unlock();
  workers.wait_idle();
  EXPECT_EQ(at_once, kMost);
  EXPECT_EQ(workers.num_threads(), 1U);
}

TEST(Workers, NoneAreTakenOnWithoutALimit) {
  Workers workers({.num_threads = 1, .long_work = kNever});
  std::promise<void> release;
  std::atomic<bool> is_released = false;
  bool waited = false;
  workers.make_strand().post([released = release.get_future().share()] { released.wait(); });
  workers.make_strand().post([&] { waited = is_released; });
  let_others_take_on_threads();
  EXPECT_EQ(workers.num_threads(), 1U);
  is_released = true;
  release.set_value();
  workers.join();
  EXPECT_TRUE(waited);
}

TEST(Workers, HoweverMuchShortWorkWaitsNoneAreTakenOn) {
  for (const Nanoseconds long_work : {Nanoseconds(1h), Nanoseconds::max()}) {
    Workers workers({.num_threads = 2, .long_work = long_work});
    const std::vector<Workers::Strand> strands = strands_of(workers, 8);
    std::mutex mutex;
    std::set<std::thread::id> threads;
    for (int i = 0; i < 4000; ++i) {
      strands[static_cast<std::size_t>(i % 8)].post([&] {
        const std::lock_guard lock(mutex);
        threads.insert(std::this_thread::get_id());
      });
    }
    workers.wait_idle();
    EXPECT_LE(threads.size(), 2U);
    EXPECT_EQ(workers.num_threads(), 2U);
  }
}

}  // namespace
}  // namespace kerf::host
