// Appends entries to a store in a folder, without end, and prints the number of each that is durable:
//   store_appender FOLDER
// Each has a request. Before that it prints "recovered N", the number of the last entry that the store holds.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <semaphore>
#include <string>

#include "server/service/store/sqlite_store.h"

namespace kerf {
namespace {

constexpr int kMostWaiting = 32;

std::int64_t make_sheet(store::SqliteStore& store) {
  const std::int64_t sheet = store.new_sheet_number();
  store.create({sheet, "killed", "scene", 1, {}}, nullptr);
  return sheet;
}

int append(const std::string& folder) {
  store::StoreOptions options;
  options.folder = folder;
  options.reserve_bytes = 1 << 20;
  options.keep.sheet_bytes = 4096;
  options.failed = [](const std::string& message) {
    std::fprintf(stderr, "%s\n", message.c_str());
    std::_Exit(70);
  };
  options.now = [] { return std::chrono::steady_clock::now().time_since_epoch(); };
  options.unix_us = [] { return std::int64_t{1}; };
  auto opened = store::SqliteStore::open(std::move(options));
  if (!opened.ok()) {
    std::fprintf(stderr, "%s\n", opened.error().message.c_str());
    return 1;
  }
  store::SqliteStore& store = **opened;
  const auto sheets = store.sheets();
  if (!sheets.ok()) return 1;
  const std::int64_t sheet = sheets->empty() ? make_sheet(store) : sheets->front().sheet;
  std::int64_t seq = sheets->empty() ? 0 : sheets->front().last_seq;
  std::printf("recovered %lld\n", static_cast<long long>(seq));
  std::fflush(stdout);
  std::counting_semaphore<kMostWaiting> room(kMostWaiting);
  while (true) {
    room.acquire();
    ++seq;
    const std::string name = std::to_string(seq);
    store.append({sheet, seq, seq, 1, "entry " + name, {{"Cut " + name, 1, "reply " + name}}}, [&room, seq] {
      std::printf("%lld\n", static_cast<long long>(seq));
      std::fflush(stdout);
      room.release();
    });
    if (seq % 50 == 0) store.save({sheet, seq, seq, 1, 2, 3, {}, std::string(3'000'000, 's'), nullptr}, nullptr);
  }
}

}  // namespace
}  // namespace kerf

int main(int argc, char** argv) {
  return argc == 2 ? kerf::append(argv[1]) : 2;
}
