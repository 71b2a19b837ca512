#pragma once

#include <cstddef>
#include <cstdint>

#include "server/base/result.h"

// Pages of lists, as in the Google API improvement proposal 158.
namespace kerf::api {

// 1..1000, 0 meaning 100; else kInvalidArgument OUT_OF_RANGE, field "page_size".
Result<std::size_t> page_size(std::int32_t requested);

// kInvalidArgument PAGE_TOKEN: not one that was given out.
Error bad_page_token();

}  // namespace kerf::api
