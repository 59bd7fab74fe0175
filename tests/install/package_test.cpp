// SPDX-License-Identifier: MIT
// The packages that CPack makes, unpacked and run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "base/temporary_folder.h"
#include "install/shell.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::Not;

class Package : public testing::Test {
  protected:
    ShellOutcome run(const std::string& command) const { return run_in(folder_.path(), command); }

    void pack(const std::string& generator) const {
        const ShellOutcome packed = run(MSCOMP_CPACK " --config '" + build_folder() +
                                        "/CPackConfig.cmake' -G " + generator + " -B packages");
        ASSERT_EQ(packed.code, 0) << packed.out << packed.err;
    }

    TemporaryFolder folder_;
};

TEST_F(Package, OfDebianHasProgramsAndTheLibraryApart) {
    for (const char* program : {"dpkg-deb", "dpkg-shlibdeps", "file"}) {
        if (!is_installed(program)) GTEST_SKIP() << "no " << program;
    }
    ASSERT_NO_FATAL_FAILURE(pack("DEB"));
    const std::string programs = "packages/mscomp_" MSCOMP_VERSION "_*.deb";
    const std::string library = "packages/libmscomp-dev_" MSCOMP_VERSION "_*.deb";

    const std::string depends = run("dpkg-deb -f " + programs + " Depends").out;
    for (const char* name : {"libc6", "libstdc++6", "libcholmod", "libfmt", "libyaml-cpp"}) {
        EXPECT_THAT(depends, HasSubstr(name));
    }
    EXPECT_THAT(depends, Not(HasSubstr("-dev")));
    EXPECT_THAT(run("dpkg-deb -f " + library + " Depends").out, HasSubstr("libceres-dev"));

    const std::string files = run("dpkg-deb -c " + programs).out;
    for (const char* name :
         {"./usr/bin/mscomp\n", "./usr/bin/acapfeat\n", "./usr/share/man/man1/mscomp-train.1\n",
          "./usr/share/bash-completion/completions/mscomp\n",
          "./usr/share/zsh/vendor-completions/_mscomp\n", "./usr/share/doc/mscomp/copyright\n"}) {
        EXPECT_THAT(files, HasSubstr(name));
    }
    EXPECT_THAT(files, Not(HasSubstr("/include/")));
    const std::string headers = run("dpkg-deb -c " + library).out;
    EXPECT_THAT(headers, HasSubstr("./usr/include/mscomp/acap/extract.h\n"));
    EXPECT_THAT(headers, Not(HasSubstr("/bin/")));

    const ShellOutcome version =
        run("dpkg-deb -x " + programs + " unpacked && unpacked/usr/bin/mscomp --version");
    EXPECT_EQ(version.out, "mscomp " MSCOMP_VERSION "\n") << version.err;
}

TEST_F(Package, AsAnArchiveHasEverythingUnderOneFolder) {
    ASSERT_NO_FATAL_FAILURE(pack("TGZ"));
    const ShellOutcome version =
        run("tar xzf packages/*.tar.gz && mscomp-*/bin/mscomp --version && ls -d mscomp-*/*");
    EXPECT_EQ(version.code, 0) << version.err;
    for (const char* name :
         {"mscomp " MSCOMP_VERSION "\n", "/bin\n", "/include\n", "/lib\n", "/share\n"}) {
        EXPECT_THAT(version.out, HasSubstr(name));
    }
}

}  // namespace
}  // namespace mscomp
