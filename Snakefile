"""The workflow, whose rules lie in workflow/, for runs from this folder."""


include: "workflow/Snakefile"


# what is included does not set the target of its own accord
workflow.default_target = "all"
