#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/base/result.h"

namespace kerf::host {
class Host;
}  // namespace kerf::host
namespace kerf::store {
class SqliteStore;
}  // namespace kerf::store

namespace kerf::app {

struct KeptSheetsFound {
  std::set<std::string> changed;       // ids of those that clients have changed
  std::vector<std::int64_t> left_out;  // numbers of those that were not made
};

// Makes the sheets of the store again, without those whose ids are `left_out`. `note` gets a line for each sheet that
// is not as it was: a damaged one is set aside, and all others start. Errors of the store itself.
Result<KeptSheetsFound> recover_sheets(store::SqliteStore& store, host::Host& host,
                                       const std::set<std::string>& left_out,
                                       const std::function<void(std::string_view line)>& note);

}  // namespace kerf::app
