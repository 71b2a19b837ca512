#pragma once

#include <functional>
#include <set>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::host {
class Host;
}  // namespace kerf::host
namespace kerf::store {
class SqliteStore;
}  // namespace kerf::store

namespace kerf::app {

// Makes all sheets of the store again and returns the ids of those that clients have changed. `note` gets a line for
// each sheet that is not as it was: a damaged one is set aside, and all others start. Errors of the store itself.
Result<std::set<std::string>> recover_sheets(store::SqliteStore& store, host::Host& host,
                                             const std::function<void(std::string_view line)>& note);

}  // namespace kerf::app
