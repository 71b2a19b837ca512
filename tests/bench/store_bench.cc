// The tables of tests/bench/notes/store.md: entries that are made durable in a folder.
//   store_bench FOLDER     makes and removes FOLDER/store-bench; it must lie on the disk to be measured

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <semaphore>
#include <string>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/service/store/sqlite_store.h"
#include "tests/bench/cpu_time.h"

namespace kerf::bench {
namespace {

using Time = std::chrono::steady_clock;

// A cut by a Bezier curve and its answer.
constexpr std::size_t kContentBytes = 101;
constexpr std::size_t kReplyBytes = 149;

double ms_since(Time::time_point begin) {
  return 1e3 * std::chrono::duration<double>(Time::now() - begin).count();
}

std::unique_ptr<store::SqliteStore> open(const std::filesystem::path& folder) {
  store::StoreOptions options;
  options.folder = folder;
  options.now = [] { return Time::now().time_since_epoch(); };
  options.unix_us = [] {
    return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
        .count();
  };
  options.failed = [](const std::string& message) { std::fprintf(stderr, "%s\n", message.c_str()); };
  auto opened = store::SqliteStore::open(std::move(options));
  KERF_CHECK(opened.ok(), "the store cannot be opened");
  return std::move(*opened);
}

host::JournalEntry cut(std::int64_t sheet, std::int64_t seq) {
  const std::string key = "Cut 00000000-0000-4000-8000-" + std::to_string(100'000'000'000 + 1'000'000 * sheet + seq);
  return {sheet,
          seq,
          seq,
          static_cast<std::uint64_t>(seq),
          std::string(kContentBytes, 'e'),
          {{key, static_cast<std::uint64_t>(seq), std::string(kReplyBytes, 'r')}}};
}

struct Measured {
  double per_s = 0.0;
  double p50_ms = 0.0, p99_ms = 0.0;
  double cpu_us = 0.0;  // of the process, an entry
};

// Keeps as many entries waiting, each of its own sheet, until so many are durable.
Measured run(store::SqliteStore& store, int waiting, int total) {
  std::vector<std::int64_t> sheets;
  for (int i = 0; i < waiting; ++i) {
    sheets.push_back(store.new_sheet_number());
    store.create({sheets.back(), "s", "scene", 1, {}}, nullptr);
  }
  KERF_CHECK(store.wait_until_durable().ok(), "the store failed");
  std::vector<double> latencies;
  latencies.reserve(static_cast<std::size_t>(total));
  std::binary_semaphore done(0);
  const double cpu = process_cpu_s();
  const Time::time_point begin = Time::now();
  int given = 0;
  // Callbacks run on the store's thread, one after the other; each gives the next entry of its sheet.
  std::function<void(std::int64_t, std::int64_t)> append = [&](std::int64_t sheet, std::int64_t seq) {
    ++given;
    store.append(cut(sheet, seq), [&, sheet, seq, at = Time::now()] {
      latencies.push_back(ms_since(at));
      if (given < total) append(sheet, seq + 1);
      if (static_cast<int>(latencies.size()) == total) done.release();
    });
  };
  // The first are given by a callback as well: no other thread counts.
  store.remove(0, {}, [&] {
    for (const std::int64_t sheet : sheets) append(sheet, 1);
  });
  done.acquire();
  const double wall_s = ms_since(begin) / 1e3;
  std::sort(latencies.begin(), latencies.end());
  const auto at = [&](double share) { return latencies[static_cast<std::size_t>(share * (total - 1))]; };
  return {total / wall_s, at(0.5), at(0.99), 1e6 * (process_cpu_s() - cpu) / total};
}

// Bytes of the database that an entry with its answer takes.
double bytes_a_row(const std::filesystem::path& folder) {
  constexpr int kRows = 20'000;
  open(folder);
  const auto before = static_cast<double>(std::filesystem::file_size(folder / "kerf.db"));
  run(*open(folder), 200, kRows);  // a store that is closed has no log
  return (static_cast<double>(std::filesystem::file_size(folder / "kerf.db")) - before) / kRows;
}

// Latency of single entries while states of 100 MB are written.
void print_beside_states(store::SqliteStore& store) {
  const std::int64_t sheet = store.new_sheet_number();
  store.create({sheet, "s", "scene", 1, {}}, nullptr);
  std::binary_semaphore done(0);
  const Time::time_point begin = Time::now();
  store.save({sheet, 0, 0, 1, 2, 3, {}, std::string(100'000'000, 's'), {}}, [&] { done.release(); });
  const Measured beside = run(store, 1, 200);
  done.acquire();
  std::printf("\nbeside a state of 100 MB, which took %.1f s: p50 %.1f ms, p99 %.1f ms\n", ms_since(begin) / 1e3,
              beside.p50_ms, beside.p99_ms);
}

int measure(const std::filesystem::path& parent) {
  const std::filesystem::path folder = parent / "store-bench";
  std::filesystem::remove_all(folder);
  {
    const auto store = open(folder);
    std::printf("| waiting | entries/s | p50 ms | p99 ms | CPU us an entry |\n|---|---|---|---|---|\n");
    for (const auto& [waiting, total] : {std::pair(1, 1000), std::pair(16, 10'000), std::pair(200, 60'000)}) {
      const Measured measured = run(*store, waiting, total);
      std::printf("| %d | %.0f | %.2f | %.2f | %.1f |\n", waiting, measured.per_s, measured.p50_ms, measured.p99_ms,
                  measured.cpu_us);
      std::fflush(stdout);
    }
    print_beside_states(*store);
  }
  std::filesystem::remove_all(folder);
  std::printf("%.0f bytes a row with its answer\n", bytes_a_row(folder));
  const Time::time_point begin = Time::now();
  const auto store = open(folder);
  std::printf("opened again with %lld entries: %.0f ms\n", static_cast<long long>(store->info()->entries),
              ms_since(begin));
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  return argc == 2 ? kerf::bench::measure(argv[1]) : 2;
}
