#!/usr/bin/env bash
# Writes the command's manual pages, compressed: catan(1) and catan-COMMAND(1), from its own help.
#   packaging/manual.sh CATAN FOLDER
set -euo pipefail
catan=$(realpath "${1:?usage: packaging/manual.sh CATAN FOLDER}")
folder=${2:?usage: packaging/manual.sh CATAN FOLDER}
version=$("$catan" --version | sed 's/^catan //')
mkdir -p "$folder"
rm -f "$folder"/*.gz

# page NAME WHAT HELP-COMMAND
page() {
  # help2man would fill the lines of examples to paragraphs.
  help2man --no-info --version-string="$version" --name="$2" "$3" |
    awk '/^\.SH EXAMPLES/{examples = 1; print; next}
         /^\.(SH|SS)/ && examples{examples = 0; print ".fi"}
         examples && /^\.(IP|PP)$/{print ".PP"; print ".nf"; next}
         {print}
         END{if (examples) print ".fi"}' |
    sed "1,/^\.SH NAME/s/^\.TH CATAN \"1\" \"[^\"]*\" \"[^\"]*\"/.TH ${1^^} \"1\" \"\" \"catan $version\"/" |
    sed "/^\.SH NAME/,/^\.SH SYNOPSIS/s/^catan.* \\\\- /$1 \\\\- /" | gzip -9n >"$folder/$1.1.gz"
}

commands=$("$catan" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\{1,\}\)  *\(.*\)/\1 \2/p')
page catan "schedule the CPUs of sense-react applications" "$catan"
while read -r command what; do
  page "catan-$command" "$what" "$catan $command"
done <<<"$commands"
