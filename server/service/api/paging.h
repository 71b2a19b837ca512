#pragma once

#include <cstddef>
#include <cstdint>

#include "server/base/result.h"

// Splits lists into pages, as in the Google API improvement proposal 158.
namespace kerf::api {

// Checks a page size of 1..1000; 0 means 100. kInvalidArgument OUT_OF_RANGE, field "page_size".
Result<std::size_t> page_size(std::int32_t requested);

// Returns kInvalidArgument PAGE_TOKEN, for a token that the server did not issue.
Error bad_page_token();

}  // namespace kerf::api
