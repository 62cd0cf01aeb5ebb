"""The workflow, whose rules lie in workflow/, for runs from this folder."""


include: "workflow/Snakefile"


# an included file does not set the default target
workflow.default_target = "all"
