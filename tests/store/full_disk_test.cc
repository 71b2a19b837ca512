// A full disk: changes wait, in order, and the reserve lets sheets be deleted.

#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>

#include "tests/store/fixture.h"

namespace kerf::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class FullDisk : public testing::Test {
 protected:
  void open(std::int64_t reserve_bytes) {
    store::StoreOptions options = on_.options();
    options.reserve_bytes = reserve_bytes;
    options.now = [this] { return std::chrono::nanoseconds(on_.now_ns); };
    options.unix_us = [this] {
      attempt();
      return on_.unix_us.load();
    };
    store_ = StoreOnLossyDisk::open(options);
    sheet_ = store_->new_sheet_number();
    store_->create(new_sheet(sheet_), nullptr);
    ASSERT_TRUE(store_->wait_until_durable().ok());
  }
  void fill(std::size_t left) {
    std::size_t used = 0;
    for (const auto& [path, content] : on_.disk.contents()) used += content.size();
    on_.disk.set_capacity(used + left);
  }
  // The store asks for the time with each attempt to commit.
  void attempt() {
    const std::lock_guard lock(mutex_);
    ++attempts_;
    changed_.notify_all();
  }
  void wait_for_attempts(int more) {
    std::unique_lock lock(mutex_);
    const int wanted = attempts_ + more;
    changed_.wait(lock, [&] { return attempts_ >= wanted; });
  }

  StoreOnLossyDisk on_;
  Calls calls_;
  std::int64_t sheet_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  int attempts_ = 0;
  std::unique_ptr<store::SqliteStore> store_;  // Ends first: its thread calls attempt() until then.
};

TEST_F(FullDisk, ChangesWaitInOrderAndNoneIsLost) {
  open(0);
  fill(100);
  store_->append(entry(sheet_, 1, std::string(20'000, 'x'), {request("a")}), calls_.add("1"));
  store_->append(entry(sheet_, 2), calls_.add("2"));
  wait_for_attempts(4);
  EXPECT_EQ(store_->check_room(sheet_).error().reason, "STORAGE_FULL");
  store_->append(entry(sheet_, 3), calls_.add("3"));
  EXPECT_THAT(calls_.names(), IsEmpty());
  EXPECT_EQ((*store_->sheets())[0].last_seq, 0);
  fill(1'000'000);
  ASSERT_TRUE(store_->wait_until_durable().ok());
  EXPECT_THAT(calls_.names(), ElementsAre("1", "2", "3"));
  EXPECT_EQ(store_->entries(sheet_, 0)->size(), 3u);
  (void)store_->sheets();  // the thread has looked at the room since
  EXPECT_TRUE(store_->check_room(sheet_).ok());
  EXPECT_THAT(on_.failures(), IsEmpty());
}

TEST_F(FullDisk, TheReserveLetsWhatWaitsAndDeletesThrough) {
  open(200'000);
  fill(0);
  store_->append(entry(sheet_, 1, std::string(10'000, 'x')), calls_.add("1"));
  ASSERT_TRUE(store_->wait_until_durable().ok()) << "it takes the reserve's room";
  EXPECT_EQ(store_->check_room(sheet_).error().reason, "STORAGE_FULL");
  const auto reserve = on_.disk.size("/store/reserve");
  EXPECT_TRUE(!reserve.ok() || *reserve == 0) << "an attempt to make it begins with an empty file";
  store_->remove(sheet_, {request("delete")}, calls_.add("removed"));
  ASSERT_TRUE(store_->wait_until_durable().ok());
  EXPECT_THAT(calls_.names(), ElementsAre("1", "removed"));
  fill(300'000);
  while (!store_->check_room(sheet_).ok()) ASSERT_TRUE(store_->sheets().ok());
  EXPECT_EQ(*on_.disk.size("/store/reserve"), 200'000);
}

TEST_F(FullDisk, AStateIsWrittenOnceThereIsRoom) {
  open(0);
  fill(1'500'000);
  store_->save(state(sheet_, 0, std::string(3'000'000, 's')), calls_.add("state"));
  while (store_->check_room(sheet_).ok()) ASSERT_TRUE(store_->sheets().ok());
  store_->append(entry(sheet_, 1), calls_.add("1"));
  while (calls_.names().empty()) ASSERT_TRUE(store_->sheets().ok());
  EXPECT_EQ(store_->check_room(sheet_).error().reason, "STORAGE_FULL");
  EXPECT_THAT(calls_.names(), ElementsAre("1"));
  on_.disk.set_capacity(std::size_t{1} << 40U);
  ASSERT_TRUE(store_->wait_until_durable().ok());
  EXPECT_THAT(calls_.names(), ElementsAre("1", "state"));
  EXPECT_EQ(store_->read_state(sheet_, 0)->content.size(), 3'000'000u);
  (void)store_->sheets();
  EXPECT_TRUE(store_->check_room(sheet_).ok());
}

TEST_F(FullDisk, AStoreOpensOnIt) {
  open(0);
  store_->append(entry(sheet_, 1), nullptr);
  ASSERT_TRUE(store_->wait_until_durable().ok());
  store_.reset();
  fill(0);
  store::StoreOptions options = on_.options();
  options.reserve_bytes = 100'000;
  const auto store = StoreOnLossyDisk::open(options);
  EXPECT_EQ((*store->sheets())[0].last_seq, 1);
  EXPECT_EQ(store->check_room(sheet_).error().reason, "STORAGE_FULL");
}

TEST_F(FullDisk, ABackupThatIsStoppedDoesNotWaitForRoom) {
  open(0);
  fill(0);
  store_->append(entry(sheet_, 1, std::string(20'000, 'x')), nullptr);
  wait_for_attempts(2);
  std::stop_source stop;
  Status outcome = Nothing{};
  std::thread backup([&] { outcome = store_->backup("/copy", stop.get_token()); });
  wait_for_attempts(2);
  stop.request_stop();
  backup.join();
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().reason, "BACKUP_STOPPED");
  EXPECT_THAT(on_.failures(), IsEmpty());
}

}  // namespace
}  // namespace kerf::test
