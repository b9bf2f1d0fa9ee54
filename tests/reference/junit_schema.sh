#!/usr/bin/env bash
# Holds a JUnit file of `modalign check` against the schema of Ant's JUnit reports (windyroad/JUnit-Schema, Apache-2.0),
# which is not kept here: junit_schema.sh JUnit.xsd check.xml. Needs xmllint.
set -euo pipefail
xmllint --noout --schema "$1" "$2"
