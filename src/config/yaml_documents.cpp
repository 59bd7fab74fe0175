// SPDX-License-Identifier: MIT
#include "yaml_documents.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>
#include <vector>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

/// Where the documents of a text begin. yaml-cpp 0.7 makes no way past a comma outside of brackets
/// and finds documents there for ever, so no more than two are looked for.
class DocumentStarts final : public YAML::EventHandler {
  public:
    explicit DocumentStarts(const std::string& yaml) {
        std::istringstream text(yaml);
        YAML::Parser parser(text);
        while (starts_.size() < 2 && parser.HandleNextDocument(*this)) {
        }
    }

    const std::vector<YAML::Mark>& marks() const { return starts_; }

    void OnDocumentStart(const YAML::Mark& mark) override { starts_.push_back(mark); }
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
    void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
    void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  const std::string& /*value*/) override {}
    void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/,
                         YAML::anchor_t /*anchor*/, YAML::EmitterStyle::value /*style*/) override {}
    void OnSequenceEnd() override {}
    void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/,
                    YAML::anchor_t /*anchor*/, YAML::EmitterStyle::value /*style*/) override {}
    void OnMapEnd() override {}

  private:
    std::vector<YAML::Mark> starts_;
};

}  // namespace

void require_one_document(const std::string& yaml, const std::string& path,
                          const std::string& key) {
    const DocumentStarts documents(yaml);
    if (documents.marks().size() < 2) return;
    const YAML::Mark& first = documents.marks()[0];
    const YAML::Mark& second = documents.marks()[1];
    throw ConfigError({path, second.line + 1, second.column + 1}, key,
                      second.pos == first.pos ? "not valid YAML: unexpected ','"
                                              : "a second YAML document; wanted one");
}

}  // namespace mscomp
