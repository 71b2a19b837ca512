#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "kerf/v1/cuts.pb.h"

namespace kerf::api {

// The applied cuts of every sheet since its last reset, by topology version, which each cut raises. Bounded: of a sheet
// whose cuts take more than kMaxBytes the oldest are forgotten. Thread-safe.
class CutJournal {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{16} << 20;     // serialised, a sheet
  static constexpr std::size_t kMaxPageBytes = std::size_t{2} << 20;  // serialised; gRPC clients take 4 MiB a message

  void add(const std::string& sheet, v1::Cut cut, v1::CutResult result);
  void forget(const std::string& sheet);

  // At most `count` entries with a topology version above `after`, and of more than one at most kMaxPageBytes, oldest
  // first; `more`: there are others behind them.
  struct Page {
    std::vector<v1::ListCutsResponse::Entry> entries;
    bool more = false;
  };
  Page page(const std::string& sheet, std::int32_t after, std::size_t count) const;

 private:
  struct Log {
    std::map<std::int32_t, v1::ListCutsResponse::Entry> entries;
    std::size_t bytes = 0;
  };

  mutable std::mutex mutex_;
  std::map<std::string, Log> logs_;
};

}  // namespace kerf::api
