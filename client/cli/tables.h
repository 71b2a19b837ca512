#pragma once

#include <cstdint>
#include <string>

#include <google/protobuf/map.h>
#include <google/protobuf/repeated_ptr_field.h>

#include "kerf/v1/analysis.pb.h"
#include "server/base/disk.h"
#include "server/base/result.h"

// Formats tables of probes and vibrations, for people and for other programs.
namespace kerf::cli {

// Writes each table as `folder`/NAME.csv, with numbers that read back exactly; does nothing if `folder` is empty.
Status write_csv(Disk& disk, const std::string& folder, const google::protobuf::RepeatedPtrField<v1::Table>& tables);

// Returns the first rows and the last of a table, each line begun with a newline.
std::string excerpt(const v1::Table& table);
std::string describe(const v1::StaticResult& statics);
std::string describe(const v1::DynamicResult& dynamics);
// Returns a line per flag, begun with a newline.
std::string describe_flags(const google::protobuf::Map<std::string, std::int64_t>& flagged_ticks);

// Returns an exit code; prints the load reached if the analysis did not complete.
int check_converged(const v1::StaticResult& statics);

}  // namespace kerf::cli
