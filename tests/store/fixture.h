#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/service/store/sqlite_store.h"
#include "tests/store/lossy_disk.h"
#include "tests/store/lossy_vfs.h"

namespace kerf::test {

inline host::StoredRequest request(const std::string& key, const std::string& reply = "done") {
  return {key, 17, reply};
}
inline host::JournalEntry entry(std::int64_t sheet, std::int64_t seq, std::string content = {},
                                std::vector<host::StoredRequest> requests = {}) {
  if (content.empty()) content = "change " + std::to_string(seq) + " of " + std::to_string(sheet);
  return {
      sheet, seq, 10 * seq, static_cast<std::uint64_t>(1000 * sheet + seq), std::move(content), std::move(requests)};
}
inline host::NewStoredSheet new_sheet(std::int64_t sheet, std::vector<host::StoredRequest> requests = {}) {
  return {sheet, "sheet-" + std::to_string(sheet), "scene of " + std::to_string(sheet), 1'000'000, std::move(requests)};
}
inline host::StoredState state(std::int64_t sheet, std::int64_t seq, std::string content, std::string name = {}) {
  return {sheet, seq, 10 * seq + 5, 77, 78, 79, std::move(name), std::move(content), nullptr};
}

// A store on a disk in memory, with times that tests move.
class StoreOnLossyDisk {
 public:
  store::StoreOptions options() {
    store::StoreOptions options;
    options.folder = "/store";
    options.files = &disk;
    options.vfs = vfs_.name();
    options.reserve_bytes = 0;
    options.retry_delay = std::chrono::milliseconds(1);
    options.now = [this] { return std::chrono::nanoseconds(now_ns); };
    options.unix_us = [this] { return unix_us.load(); };
    options.failed = [this](const std::string& message) {
      const std::lock_guard lock(mutex_);
      failures_.push_back(message);
    };
    return options;
  }
  std::unique_ptr<store::SqliteStore> open() { return open(options()); }
  static std::unique_ptr<store::SqliteStore> open(const store::StoreOptions& options) {
    auto opened = store::SqliteStore::open(options);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return opened.ok() ? std::move(*opened) : nullptr;
  }
  Result<store::StoreReport> check() { return store::check_store("/store", disk, vfs_.name()); }
  std::vector<std::string> failures() {
    const std::lock_guard lock(mutex_);
    return failures_;
  }

  LossyDisk disk;
  std::atomic<std::int64_t> now_ns = 0;
  std::atomic<std::int64_t> unix_us = 1'700'000'000'000'000;

 private:
  LossyVfs vfs_{disk};
  std::mutex mutex_;
  std::vector<std::string> failures_;
};

// Holds the store's thread in a callback, so that what is given meanwhile is one transaction.
class HeldStore {
 public:
  explicit HeldStore(store::SqliteStore& store) {
    std::promise<void> held;
    store.remove(0, {}, [this, &held] {
      held.set_value();
      released_.get_future().wait();
    });
    held.get_future().wait();
  }
  void release() { released_.set_value(); }

 private:
  std::promise<void> released_;
};

// Lists what was called back, in order.
class Calls {
 public:
  host::Journal::Durable add(std::string name) {
    return [this, name = std::move(name)] {
      const std::lock_guard lock(mutex_);
      names_.push_back(name);
    };
  }
  std::vector<std::string> names() {
    const std::lock_guard lock(mutex_);
    return names_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> names_;
};

}  // namespace kerf::test
