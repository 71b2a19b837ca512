// StoreService over a store that answers when the test says so.

#include <condition_variable>
#include <future>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "server/service/api/kept_store.h"
#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

using ::testing::HasSubstr;

class FakeStore : public KeptStore {
 public:
  Result<v1::StoreInfo> info() override {
    wait({});
    v1::StoreInfo info;
    info.set_folder("/data");
    info.set_sheets(3);
    v1::SetAsideSheet& aside = *info.add_set_aside();
    aside.set_sheet_id("torn");
    aside.set_reason("entry 5 is missing");
    return info;
  }
  Result<v1::PruneStoreResponse> prune() override {
    v1::PruneStoreResponse pruned;
    pruned.set_removed_answers(7);
    return pruned;
  }
  Status delete_set_aside(std::int64_t number) override {
    return number == 5 ? Status(Nothing{}) : not_found("SET_ASIDE_NOT_FOUND", "none", "number");
  }
  Result<v1::StoreBackup> back_up(const std::string& id, const std::stop_token& stop) override {
    if (!wait(stop)) return aborted("BACKUP_STOPPED", "given up");
    if (id == "twice") return already_exists("BACKUP_EXISTS", "there is one", "backup_id");
    v1::StoreBackup backup;
    backup.set_backup_id(id);
    backup.set_num_bytes(12);
    return backup;
  }

  void hold() {
    const std::lock_guard lock(mutex_);
    is_held_ = true;
  }
  void release() {
    const std::lock_guard lock(mutex_);
    is_held_ = false;
    changed_.notify_all();
  }
  void wait_until_asked(int times) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return asked_ >= times; });
  }

 private:
  // Waits while the store is held. Returns false if `stop` ends that.
  bool wait(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    ++asked_;
    changed_.notify_all();
    return changed_.wait(lock, stop, [this] { return !is_held_; });
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  bool is_held_ = false;
  int asked_ = 0;
};

// An answer that comes from a thread of the Api.
template <typename T>
class Later {
 public:
  Reply<T> callback() {
    return [promise = promise_](Result<T> result) { promise->set_value(std::move(result)); };
  }
  Result<T> wait() { return future_.get(); }
  [[nodiscard]] bool is_there() const { return future_.wait_for(0s) == std::future_status::ready; }

 private:
  std::shared_ptr<std::promise<Result<T>>> promise_ = std::make_shared<std::promise<Result<T>>>();
  std::future<Result<T>> future_ = promise_->get_future();
};

class ApiStoreTest : public ApiTest {
 protected:
  ApiStoreTest() {
    Limits limits;
    limits.max_waiting_store_calls = 1;
    make_api(limits, nullptr, &store_);
  }
  ~ApiStoreTest() override {
    store_.release();
    api_.reset();
  }

  Later<v1::StoreBackup> begin_backup(const std::string& id) {
    v1::BackupStoreRequest request;
    request.set_backup_id(id);
    Later<v1::StoreBackup> later;
    api_->backup_store(request, later.callback());
    return later;
  }
  Later<v1::StoreInfo> begin_info() {
    Later<v1::StoreInfo> later;
    api_->get_store_info({}, later.callback());
    return later;
  }

  FakeStore store_;
};

TEST_F(ApiTest, WithoutAStoreCallsOfStoreServiceSayWhatToDo) {
  for (const char* method : {"GetStoreInfo", "PruneStore", "DeleteSetAsideSheet", "BackupStore"}) {
    const Result<std::string> reply = call_json(std::string("/kerf.v1.StoreService/") + method, "{}");
    ASSERT_FALSE(reply.ok()) << method;
    EXPECT_EQ(reply.error().code, ErrorCode::kFailedPrecondition) << method;
    EXPECT_EQ(reply.error().reason, "NO_STORE") << method;
    EXPECT_THAT(reply.error().message, HasSubstr("start kerfd with --data DIR"));
  }
}

TEST_F(ApiStoreTest, AnswersAreThoseOfTheStore) {
  const Result<v1::StoreInfo> info = begin_info().wait();
  ASSERT_TRUE(info.ok()) << info.error().message;
  EXPECT_EQ(info->sheets(), 3);
  EXPECT_EQ(info->set_aside(0).reason(), "entry 5 is missing");
  Later<v1::PruneStoreResponse> pruned;
  api_->prune_store({}, pruned.callback());
  EXPECT_EQ(pruned.wait().value().removed_answers(), 7);
  for (const std::int64_t number : {5, 6}) {
    v1::DeleteSetAsideSheetRequest request;
    request.set_number(number);
    Later<google::protobuf::Empty> deleted;
    api_->delete_set_aside_sheet(request, deleted.callback());
    const Result<google::protobuf::Empty> outcome = deleted.wait();
    EXPECT_EQ(outcome.ok(), number == 5);
    EXPECT_EQ(outcome.ok() ? "number" : outcome.error().field, "number");
  }
  EXPECT_EQ(begin_backup("monday").wait().value().num_bytes(), 12);
  const Result<v1::StoreBackup> refused = begin_backup("twice").wait();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "BACKUP_EXISTS");
  EXPECT_EQ(refused.error().field, "backup_id");
}

TEST_F(ApiStoreTest, JsonNamesAreThoseOfTheMessages) {
  for (const Method& method : api_->methods()) {
    if (method.path != "/kerf.v1.StoreService/BackupStore") continue;
    Later<std::string> later;
    method.call(R"({"backup_id":"a-1"})", Encoding::kJson, caller_, later.callback(), {});
    EXPECT_THAT(later.wait().value(), HasSubstr(R"("backup_id":"a-1")"));
  }
}

TEST_F(ApiStoreTest, ABackupHasAPlainName) {
  const std::string longest(63, '9');
  for (const std::string& id :
       {std::string(), std::string("-a"), std::string("A"), std::string("a/b"), std::string(".."),
        std::string("a.part"), std::string("a b"), std::string("a\0b", 3), std::string("\xc3\xa4"), longest + "9"}) {
    const Result<v1::StoreBackup> refused = begin_backup(id).wait();
    ASSERT_FALSE(refused.ok()) << id;
    EXPECT_EQ(refused.error().reason, "BACKUP_ID") << id;
    EXPECT_EQ(refused.error().field, "backup_id") << id;
  }
  for (const std::string& id : {std::string("0"), std::string("a"), std::string("2026-11-30"), longest}) {
    EXPECT_TRUE(begin_backup(id).wait().ok()) << id;
  }
}

TEST_F(ApiStoreTest, OneBackupIsMadeAtATimeAndOthersAreAnsweredMeanwhile) {
  store_.hold();
  Later<v1::StoreBackup> first = begin_backup("first");
  store_.wait_until_asked(1);
  const Result<v1::StoreBackup> refused = begin_backup("second").wait();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "BACKUP_UNDER_WAY");
  Later<v1::PruneStoreResponse> pruned;
  api_->prune_store({}, pruned.callback());
  EXPECT_TRUE(pruned.wait().ok()) << "beside the backup";
  EXPECT_FALSE(first.is_there());
  store_.release();
  EXPECT_TRUE(first.wait().ok());
  EXPECT_TRUE(begin_backup("second").wait().ok()) << "once the first was answered";
  EXPECT_FALSE(begin_backup("twice").wait().ok());
  EXPECT_TRUE(begin_backup("third").wait().ok()) << "once one was refused";
}

TEST_F(ApiStoreTest, CallsThatWaitAreBounded) {
  store_.hold();
  std::vector<Later<v1::StoreInfo>> asked;
  for (int i = 0; i < 2; ++i) asked.push_back(begin_info());
  store_.wait_until_asked(2);
  asked.push_back(begin_info());
  const Result<v1::StoreInfo> refused = begin_info().wait();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "TOO_MANY_STORE_CALLS");
  const Result<v1::StoreBackup> backup = begin_backup("a").wait();
  ASSERT_FALSE(backup.ok());
  EXPECT_EQ(backup.error().reason, "TOO_MANY_STORE_CALLS");
  store_.release();
  for (Later<v1::StoreInfo>& each : asked) EXPECT_TRUE(each.wait().ok());
  EXPECT_TRUE(begin_backup("a").wait().ok()) << "the refused one is not under way";
}

TEST_F(ApiStoreTest, AStopGivesABackupUp) {
  store_.hold();
  Later<v1::StoreBackup> backup = begin_backup("a");
  store_.wait_until_asked(1);
  api_->stop();
  const Result<v1::StoreBackup> stopped = backup.wait();
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().reason, "SERVER_STOPPING");
  EXPECT_EQ(begin_backup("b").wait().error().reason, "SERVER_STOPPING");
}

}  // namespace
}  // namespace kerf::api
