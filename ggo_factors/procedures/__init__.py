"""The paper's procedures: from a task to checked steps."""
