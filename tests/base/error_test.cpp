// SPDX-License-Identifier: MIT
#include "mscomp/base/error.h"

#include <gtest/gtest.h>

#include <csignal>

namespace mscomp {
namespace {

// Scripts tell failures apart by these numbers; they are a contract.
TEST(Errors, LeadToTheExitCodeOfTheirKind) {
    EXPECT_EQ(static_cast<int>(UsageError("").exit_code()), 2);
    EXPECT_EQ(static_cast<int>(ConfigError({}, "", "").exit_code()), 2);
    EXPECT_EQ(static_cast<int>(InputError({}, "").exit_code()), 3);
    EXPECT_EQ(static_cast<int>(MeshError("").exit_code()), 3);
    EXPECT_EQ(static_cast<int>(IoError("", "").exit_code()), 4);
    EXPECT_EQ(static_cast<int>(NumericalError("").exit_code()), 5);
    EXPECT_EQ(static_cast<int>(CheckpointError("", "").exit_code()), 6);
    EXPECT_EQ(static_cast<int>(Interrupted(SIGINT, "").exit_code()), 130);
    EXPECT_EQ(static_cast<int>(Interrupted(SIGTERM, "").exit_code()), 143);
}

TEST(Errors, SayWhereAsFarAsKnown) {
    EXPECT_STREQ(InputError({"a.obj", 3, 7}, "bad").what(), "a.obj:3:7: bad");
    EXPECT_STREQ(InputError({"a.obj", 3}, "bad").what(), "a.obj:3: bad");
    EXPECT_STREQ(InputError({"a.obj"}, "bad").what(), "a.obj: bad");
    EXPECT_STREQ(InputError({}, "bad").what(), "bad");
}

// A file names a tensor or a key as it likes; the message stays one line that cannot steer a
// terminal.
TEST(Errors, ShowNoControlCharactersOfAFile) {
    EXPECT_STREQ(InputError({"a.obj", 3}, "tensor '\x1b[31m\n\x7f\xc3\xa9'").what(),
                 "a.obj:3: tensor '?[31m??\xc3\xa9'");
    EXPECT_STREQ(ConfigError({"c.yaml"}, "a\tb", "got '\r'").what(), "c.yaml: a?b: got '?'");
}

TEST(Errors, KeepThePlaceForPrograms) {
    const InputError error({"a.obj", 3, 7}, "bad");
    EXPECT_EQ(error.where().path, "a.obj");
    EXPECT_EQ(error.where().line, 3);
    EXPECT_EQ(error.where().column, 7);
}

TEST(Errors, OfAConfigurationNameTheKey) {
    const ConfigError error({"c.yaml", 2, 1}, "model.kind", "got 'x'");
    EXPECT_STREQ(error.what(), "c.yaml:2:1: model.kind: got 'x'");
    EXPECT_EQ(error.key(), "model.kind");
}

}  // namespace
}  // namespace mscomp
